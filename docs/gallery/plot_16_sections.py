"""
Poincaré sections of chaos
==========================

The state once per period of the force, colored by how many points lie near one another; and the
field's other map, the phase of the force and the speed at each impact.
"""

import nlds_vines as nv

system = nv.load_system("ssul-set6", omega=7.4, K=2.5e7)
nv.orbit_portrait(
    system,
    windows=[[400, 3400]],
    samples=32,
    panels=["section", "impact-section"],
    to="sections.png",
)
