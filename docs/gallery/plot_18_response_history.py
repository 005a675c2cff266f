"""
A blow
======

An impulse strikes the structure at rest: how its energy falls with each damper, and where it goes.
"""

import nlds_vines as nv

nv.response_history(["none", "tmd", "ssul-set6"], impulse=1000.0, duration=15.0).plot().savefig(
    "history.png", dpi=200
)
