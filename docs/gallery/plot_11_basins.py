"""
Basins of attraction
====================

At 7.7 rad/s the start decides where the orbit ends.  Each cell is a start of the damper,
displacement and velocity; its color is that of the attractor that it is drawn to.
"""

import nlds_vines as nv

plane = {
    "system": "ssul-set6",
    "set": {"omega": 7.7},
    "vary": {
        "x2_0": {"start": 0.1, "stop": 0.26, "num": 80},
        "v2_0": {"start": -1.0, "stop": 1.0, "num": 80},
    },
    "record": {"want": ["attractor"]},
}
nv.scan(plane).plot().savefig("basins.png", dpi=200)
