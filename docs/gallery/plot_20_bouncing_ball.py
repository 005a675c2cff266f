"""
A ball on a vibrating table
===========================

A system of the textbooks, without units: mass and gravity are 1, the table moves with frequency
1.6, and a bounce keeps 0.15 of the speed.  The amplitude of the table is varied.
"""

import nlds_vines as nv

scan = {
    "system": "bouncing-ball",
    "vary": {"Y": {"start": 0.85, "stop": 1.2, "num": 251}},
    "record": {"want": ["section", "regime"]},
}
nv.scan(scan).plot().savefig("ball.png", dpi=200)
