"""
Curves of special points in a plane
===================================

Where the orbit ``T,1`` loses its stability, and where its impact becomes a graze, over frequency
and force: the borders of its regime without computing a map.
"""

import nlds_vines as nv

found = nv.follow("ssul-set6", along="omega", between=(7.0, 8.0), plane=("P", 600.0, 1000.0))
found.plot().savefig("plane.png", dpi=200)
