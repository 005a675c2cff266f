"""The figure of the method: one forcing period of Set 6 with its cells, the touch and the contact.

python docs/site/method.py        # writes docs/method.png
"""

from __future__ import annotations

from pathlib import Path

import matplotlib
import numpy as np
from matplotlib.figure import Figure

import nlds_vines as nv

CELLS = 16  # drawn in a period; the program chooses their number
NODES = 12  # collocation points of the contact
STATES = 16_384  # in each period of the trajectory
BEGIN = 0.5  # of the drawn period, in periods


def figure() -> Figure:
    """Return the figure."""
    matplotlib.use("Agg")
    matplotlib.rcParams["font.size"] = 7
    import matplotlib.pyplot as plt

    system = nv.load_system("ssul-set6", omega=6.28)
    orbit = nv.simulate(
        system, 2, transient=600, samples=STATES, record=("trajectory", "impacts"), quiet=True
    )
    assert orbit.trajectory is not None
    assert orbit.time is not None
    assert orbit.impacts is not None
    start = 600 * system.period
    time = (orbit.time - start) / system.period
    f = system.parameters["V"] - (orbit.trajectory[:, 2] - orbit.trajectory[:, 0])  # minus the gap
    hit = orbit.impacts[orbit.impacts["touch"] >= start + BEGIN * system.period][0]
    touch, release = ((hit[name] - start) / system.period for name in ("touch", "release"))
    drawn, (whole, cell, contact) = plt.subplots(
        1, 3, figsize=(16 / 2.54, 5 / 2.54), layout="constrained"
    )
    edges = BEGIN + np.linspace(0.0, 1.0, CELLS + 1)
    shown = (time >= BEGIN) & (time <= BEGIN + 1.0)
    whole.plot(time[shown], 1e3 * f[shown], color="#0072b2")
    whole.plot(edges, 1e3 * np.interp(edges, time, f), ".", color="#0072b2", markersize=4)
    whole.axhline(0.0, color="0.5", linewidth=0.8)
    whole.axvspan(touch, release, color="#d55e00", alpha=0.3, linewidth=0)
    whole.set(xlabel="time / T", ylabel="f, minus the gap [mm]", title="(a) one period")

    low, high = edges[edges <= touch][-1], edges[edges > touch][0]
    inside = (time >= low) & (time <= min(high, release))
    cell.plot(time[inside], 1e3 * f[inside], color="#0072b2")
    cell.axhline(0.0, color="0.5", linewidth=0.8)
    cell.plot(touch, 0.0, "o", color="#d55e00", markersize=5)
    cell.annotate("touch", (touch, 0.0), (0.08, 0.86), textcoords="axes fraction",
                  arrowprops={"arrowstyle": "-", "color": "0.4"})  # fmt: skip
    cell.set(xlabel="time / T", ylabel="f [mm]", title="(b) the cell of the touch")

    inside = (time >= touch) & (time <= release)
    nodes = touch + (release - touch) * 0.5 * (1.0 + np.polynomial.legendre.leggauss(NODES)[0])
    contact.plot(1e3 * (time[inside] - touch) * system.period, 1e3 * f[inside], color="#d55e00")
    contact.plot(1e3 * (nodes - touch) * system.period, 1e3 * np.interp(nodes, time, f), ".",
                 color="#d55e00", markersize=5)  # fmt: skip
    contact.set(xlabel="time since touch [ms]", ylabel="depth z [mm]", title="(c) the contact")
    return drawn


if __name__ == "__main__":
    figure().savefig(Path(__file__).parents[1] / "method.png", dpi=200)
