"""
Hysteresis
==========

``both`` follows the attractor to greater and to smaller frequencies.  Where the two differ, regimes
coexist, and the way decides which one is reached.  Below is the largest Lyapunov exponent with its
99 % interval.
"""

import nlds_vines as nv

scan = {
    "system": "ssul-set6",
    "vary": {"omega": {"start": 7.2, "stop": 7.8, "num": 121}},
    "start": {"policy": "both"},
    "record": {"want": ["section", "regime", "lyapunov"]},
}
nv.scan(scan).plot().savefig("hysteresis.png", dpi=200)
