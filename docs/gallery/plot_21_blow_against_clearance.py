"""
A blow against the clearance
============================

How long the structure's energy stays above 1 % of its largest value, by the impulse of the blow and
the clearance: a damper that is far from its obstacle needs a harder blow.
"""

import nlds_vines as nv

vary = {
    "impulse": {"start": 100, "stop": 2000, "num": 20},
    "C": {"start": 0, "stop": 0.2, "num": 16},
}
nv.response_history("ssul-set6", vary=vary, duration=15.0).plot().savefig("blows.png", dpi=200)
