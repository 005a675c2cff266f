"""
Basins of a bistable sink
=========================

Under a weak force each well of a bistable sink has an attractor of its own.  Each cell is a start
of the sink's mass, displacement and velocity, while the structure is at rest; its color tells the
attractor in which the orbit ends.
"""

import nlds_vines as nv

host = nv.chain([1.0], [1.0], ratio=0.02)
nes = nv.Damper("nes", attached_to="x1", m=0.02, k=-0.01, c=0.002, spring=nv.Spring(k3=0.44442))
system = nv.System.from_host(host, [nes], force={"x1": 0.002}, omega=0.8, title="bistable sink")
plane = {
    "system": system,
    "vary": {
        "nes_0": {"start": -0.5, "stop": 0.5, "num": 45},
        "v_nes_0": {"start": -0.4, "stop": 0.4, "num": 37},
    },
    "sampling": {"transient": 200, "periods": 20},
    "record": {"want": ["attractor"]},
}
nv.scan(plane).plot().savefig("wells.png", dpi=200)
