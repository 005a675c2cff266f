"""
A figure of your own
====================

Largest energy of the structure over the frequency, with three clearances of the damper and without
a damper: read from archives, drawn with matplotlib.
"""

import matplotlib.pyplot as plt
import numpy as np

import nlds_vines as nv

omega = {"start": 5.0, "stop": 8.0, "num": 151}
sampling = {"transient": 400, "periods": 60}
scans = {
    "alone": {"system": "none", "vary": {"omega": omega}},
    "damper": {
        "system": "ssul-set6",
        "vary": {"omega": omega, "C": {"values": [0.02, 0.06, 0.1]}},
    },
}
for name, scan in scans.items():
    nv.scan(scan, sampling=sampling, record=["energy", "regime"], to=f"{name}.h5")

# %%
# The dimensions of ``E1max`` are the varied parameters and the start, of which there is one.  A
# curve joins no two regimes: a NaN stands between different labels.


def curve(archive, *place):
    """Return frequencies and largest energies, broken where the regime changes."""
    at = (slice(None), *place, 0)
    label, E1max = archive["label"][at], archive["E1max"][at]
    other = np.flatnonzero(label[1:] != label[:-1]) + 1
    return [np.insert(values, other, np.nan) for values in (archive["omega"], E1max)]


figure, axes = plt.subplots(figsize=(6.3, 3.6), layout="constrained")
with nv.read("alone.h5") as archive:
    axes.plot(*curve(archive), color="#767676", label="no damper")
colors = ("#56b4e9", "#0072b2", "#d55e00")
with nv.read("damper.h5") as archive:
    for j, clearance in enumerate(archive["C"]):
        label = f"$C$ = {clearance:g} m"
        axes.plot(*curve(archive, j), color=colors[j], label=label)
axes.set_xlabel(r"angular frequency of the force $\omega$ [rad/s]")
axes.set_ylabel(r"energy of the structure $E_1^\mathrm{max}$ [J]")
axes.set(xlim=(5, 8), ylim=(0, None))
axes.legend(frameon=False)
plt.show()
