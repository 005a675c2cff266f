"""
A structure that is shaken
==========================

The ground moves with an acceleration of 1 m/s² in place of a force: how much of it reaches the
structure, and how far the damper travels.
"""

import nlds_vines as nv

scan = {
    "system": "ssul-set6",
    "set": {"base_acceleration": 1.0},
    "vary": {"omega": {"start": 5.0, "stop": 7.5, "num": 101}},
    "sampling": {"transient": 400, "periods": 60},
    "record": {"want": ["response", "regime"]},
}
archive = nv.scan(scan)
archive.plot("transmissibility,a1_max,stroke_max").savefig("shaken.png", dpi=200)
