"""
One orbit in full
=================

The bilateral damper at 5.6 rad/s: it strikes the structure once in two periods, ``2T,1``, and never
the obstacle.
"""

import nlds_vines as nv

system = nv.load_system("ssbl", omega=5.6)
figure = nv.orbit_portrait(system, to="portrait.png")
