"""
Spectra over a parameter
========================

The spectrum of the structure's displacement at each frequency of the force, upwards, in decades of
color, below the section.  A period of 3T has lines at thirds, chaos fills the space between them.
"""

import nlds_vines as nv

scan = {
    "system": "ssul-set6",
    "vary": {"omega": {"start": 7.25, "stop": 7.6, "num": 71}},
    "sampling": {"transient": 600, "periods": 120},
    "record": {"want": ["section", "regime", "spectrum"]},
}
nv.scan(scan).plot("x2,spectrum:x1").savefig("waterfall.png", dpi=200)
