"""
A map of coexisting regimes
===========================

Frequency against force, from four random starts in each cell.  The upper panel has the regime that
most starts ended in, the lower one how many regimes were found.
"""

import nlds_vines as nv

scan = {
    "system": "ssul-set6",
    "vary": {
        "omega": {"start": 7.0, "stop": 8.0, "num": 41},
        "P": {"start": 400.0, "stop": 1200.0, "num": 31},
    },
    "start": {"policy": "random", "count": 4},
    "sampling": {"transient": 240, "periods": 60},
    "record": {"want": ["regime", "settling"]},
}
archive = nv.scan(scan, to="map.h5")
archive.plot().savefig("map.png", dpi=200)

# %%
# The same archive shows other things: here for how many periods orbits need until they settle.

archive.plot("settling").savefig("settling.png", dpi=200)
