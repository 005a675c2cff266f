"""
A tuning
========

Stiffness and clearance of a damper, searched for the least energy of the structure at one
frequency: shades and contours of the objective, a star at the best design.
"""

import nlds_vines as nv

found = nv.tune(
    {
        "system": "ssul-set6",
        "free": {"k2": {"low": 100.0, "high": 1500.0}, "C": {"low": 0.0, "high": 0.3}},
        "set": {"c2": 50.0},
        "search": {"population": 20, "generations": 15, "polish": 60},
        "surface": {"parameters": ["k2", "C"], "size": 31},
    }
)
print(found)
found.plot().savefig("tuning.png", dpi=200)
