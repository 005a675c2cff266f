"""
A bifurcation diagram
=====================

The damper of the paper, SSul NES Set 6, where its regimes change.  Dots are the states once per
period of the force; the strip on top has the regimes, the green curve the structure's energy.
"""

import nlds_vines as nv

scan = {"system": "ssul-set6", "vary": {"omega": {"start": 7.2, "stop": 7.8, "num": 241}}}
nv.scan(scan).plot().savefig("diagram.png", dpi=200)
