"""
Which sink?
===========

One structure with a tuned, a cubic, a bistable and a vibro-impact damper of 2 % of its mass: the
largest energy of the structure over the frequency of a force, swept up and down.  The cubic sink is
that of Dekemele, De Keyser and Loccufier (2018); the bistable one has wells whose frequency is that
of the structure.
"""

import nlds_vines as nv

host = nv.chain([1.0], [1.0], ratio=0.005)
walls = [nv.Wall(0.06, side, law="restitution", e=0.8) for side in "+-"]
dampers = {
    "tuned": {"frequency_ratio": 0.98, "zeta": 0.084},
    "cubic": {"c": 0.002, "spring": nv.Spring(k3=0.44442)},
    "bistable": {"c": 0.002, "k": -0.01, "spring": nv.Spring(k3=0.44442)},
    "vibro-impact": {"walls": walls},
}
sinks = []
for title, numbers in dampers.items():
    nes = nv.Damper("nes", attached_to="x1", m=0.02, **numbers)
    sinks.append(nv.System.from_host(host, [nes], force={"x1": 0.002}, omega=1.0, title=title))

curves = nv.response_curves(
    sinks,
    vary={"omega": {"start": 0.9, "stop": 1.1, "num": 61}},
    start={"policy": "both"},
    sampling={"transient": 200, "periods": 60},
)
curves.plot().savefig("sinks.png", dpi=200)
