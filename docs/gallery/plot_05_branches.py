"""
Branches: why a regime ends
===========================

The orbit ``T,1`` is followed from 7 to 8 rad/s, also where it is not stable (dotted).  So are the
orbits of twice its period, which leave it at period doublings (PD).
"""

import matplotlib.pyplot as plt
import numpy as np

import nlds_vines as nv

found = nv.continue_branch("ssul-set6", parameter="omega", bounds=(7.0, 8.0), doublings=1)
for row in found.special_points[:3]:
    print(row.kind, f"{row.value:.6f} rad/s", row.before, row.after)

# %%
# Each branch has its points as arrays: parameter, energy, whether they are stable, and more.

figure, axes = plt.subplots(figsize=(6.3, 3.6), layout="constrained")
for branch, color in zip(found.branches, ("#0072b2", "#d55e00", "#009e73"), strict=True):
    for stable, line in ((True, "-"), (False, ":")):
        energy = np.where(branch.stable == stable, branch.E1max, np.nan)
        axes.plot(branch.parameter, energy, line, color=color)
for row in found.special_points:
    if row.kind == "PD" and row.branch == 0:
        axes.axvline(row.value, color="#767676", linewidth=0.6)
        axes.annotate(" PD", (row.value, 0.97), xycoords=("data", "axes fraction"), va="top")
axes.set_xlabel(r"angular frequency of the force $\omega$ [rad/s]")
axes.set_ylabel(r"energy of the structure $E_1^\mathrm{max}$ [J]")
axes.set(xlim=(7, 8), ylim=(0, None))
plt.show()
