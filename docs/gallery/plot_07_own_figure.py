"""
A figure of your own
====================

Largest energy of the structure over the frequency, with three clearances of the damper and without
a damper: read from archives, drawn with matplotlib.
"""

import matplotlib.pyplot as plt

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
    nv.scan(scan, sampling=sampling, record=["energy"], to=f"{name}.h5")

# %%
# The dimensions of ``E1max`` are the varied parameters and the start, of which there is one.

figure, axes = plt.subplots(figsize=(6.3, 3.6), layout="constrained")
with nv.read("alone.h5") as archive:
    axes.plot(archive["omega"], archive["E1max"][:, 0], color="#767676", label="no damper")
colours = ("#56b4e9", "#0072b2", "#d55e00")
with nv.read("damper.h5") as archive:
    for j, clearance in enumerate(archive["C"]):
        label = f"$C$ = {clearance:g} m"
        axes.plot(archive["omega"], archive["E1max"][:, j, 0], color=colours[j], label=label)
axes.set_xlabel(r"angular frequency of the force $\omega$ [rad/s]")
axes.set_ylabel(r"energy of the structure $E_1^\mathrm{max}$ [J]")
axes.set(xlim=(5, 8), ylim=(0, None))
axes.legend(frameon=False)
plt.show()
