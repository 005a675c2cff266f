"""
A film of an orbit
==================

Structure and damper in motion over four periods of the force, as
``film.gif``.  A ``FuncAnimation`` of matplotlib moves what a trajectory holds.
"""

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.animation import FuncAnimation, PillowWriter

import nlds_vines as nv

FRAMES = 12  # in each period of the force
system = nv.load_system("ssul-set6", omega=7.45)
orbit = nv.simulate(system, 4, transient=400, record=["trajectory"], samples=FRAMES, quiet=True)
table = orbit.to_dataframe()
time, x1, x2 = (table[name].to_numpy() for name in ("time", "x1", "x2"))

figure, (scene, history) = plt.subplots(2, 1, height_ratios=(2, 1), layout="constrained")
scene.set(xlim=(x1.min() - 0.1, x1.max() + 0.3), ylim=(-1, 1), xlabel="position [m]", yticks=[])
(structure,) = scene.plot([], [], "s", markersize=40)
(damper,) = scene.plot([], [], "o", markersize=14)
history.plot(time, x1, time, x2)
history.set(xlabel="t [s]", ylabel="x₁, x₂ [m]")
now = history.axvline(time[0], color="black")


def draw(frame):
    """Move both bodies and the line of the present instant."""
    structure.set_data([x1[frame]], [0.5])
    damper.set_data([x2[frame]], [-0.5])
    now.set_xdata([time[frame]] * 2)
    return structure, damper, now


figure.draw_without_rendering()
figure.set_layout_engine("none")  # the layout stays as it is
film = FuncAnimation(figure, draw, frames=np.arange(len(time)), blit=False)
film.save("film.gif", writer=PillowWriter(fps=FRAMES))
