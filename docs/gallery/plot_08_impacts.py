"""
Impact speeds over the frequency
================================

How fast the damper strikes, from the impacts of single orbits: one dot for each of the impacts in
12 periods, colored by the force that it makes.
"""

import matplotlib.pyplot as plt
import numpy as np

import nlds_vines as nv

frequencies, speeds, forces = [], [], []
for omega in np.linspace(6.9, 7.6, 71):
    system = nv.load_system("ssul-set6", omega=omega)
    orbit = nv.simulate(system, periods=12, transient=400)
    frequencies += [omega] * len(orbit.impacts)
    speeds += list(orbit.impacts["speed"])
    forces += list(orbit.impacts["force"])

# %%
# A period doubling shows as a fork, an irregular orbit as a cloud.

figure, axes = plt.subplots(figsize=(6.3, 3.6), layout="constrained")
dots = axes.scatter(frequencies, speeds, c=np.array(forces) / 1000, s=6, cmap="viridis")
figure.colorbar(dots, label="largest contact force [kN]")
axes.set_xlabel(r"angular frequency of the force $\omega$ [rad/s]")
axes.set_ylabel("approach speed [m/s]")
axes.set_ylim(0, None)
plt.show()
