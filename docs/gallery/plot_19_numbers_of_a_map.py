"""
A map of a number
=================

By which share the damper reduces the energy of the structure, over frequency and clearance: orange
where it helps, violet where it harms.  The energy itself spans decades and is shaded by logarithm.
"""

import nlds_vines as nv

scan = {
    "system": "ssul-set6",
    "vary": {
        "omega": {"start": 5.0, "stop": 8.0, "num": 61},
        "C": {"start": 0.0, "stop": 0.15, "num": 31},
    },
    "sampling": {"transient": 300, "periods": 60},
    "record": {"want": ["energy"]},
}
archive = nv.scan(scan)
archive.plot("reduction").savefig("reduction.png", dpi=200)

# %%
# ``log:`` and ``linear:`` choose how a number becomes shades.

archive.plot("log:E1max").savefig("energy.png", dpi=200)
