"""
Response curves
===============

The largest energy of the structure over the frequency, with three dampers and without one; below,
by how much each damper reduces it.  Where a curve lies below zero there, the damper does harm.
"""

import nlds_vines as nv

found = nv.response_curves(
    ["none", "tmd", "ssbl", "ssul-set6"],
    vary={"omega": {"start": 5.0, "stop": 7.5, "num": 126}},
    sampling={"transient": 400, "periods": 60},
)
found.plot().savefig("curves.png", dpi=200)
