"""
Basins along a parameter
========================

From 60 random starts at each frequency: the share that each attractor draws, one upon the other.
"""

import nlds_vines as nv

scan = {
    "system": "ssul-set6",
    "vary": {"omega": {"start": 7.5, "stop": 7.9, "num": 21}},
    "start": {"policy": "random", "count": 60},
    "record": {"want": ["attractor"]},
}
nv.scan(scan).plot("basins").savefig("shares.png", dpi=200)
