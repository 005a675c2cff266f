"""
How long chaos lasts
====================

Four hundred random starts at 7.575 rad/s: the share of them that has not settled, against time, and
the exponential law of their lifetimes.
"""

import nlds_vines as nv

system = nv.load_system("ssul-set6", omega=7.575, K=2.5e7)
ensemble = nv.transient_lifetimes(system, starts=400)
ensemble.plot().savefig("lifetimes.png", dpi=200)
