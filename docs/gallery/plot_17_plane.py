"""
Curves of special points in a plane
===================================

Where the orbit ``T,1`` loses its stability, and where its impact becomes a graze, over frequency
and force: the borders of its regime without computing a map.
"""

import nlds_vines as nv

found = nv.continue_branch(
    "ssul-set6", parameter="omega", bounds=(7.2, 7.6), plane=("P", 700.0, 900.0)
)
found.plot().savefig("plane.png", dpi=200)
