"""
Pumping after a blow
====================

How long a structure keeps a tenth of its energy after a blow, by the speed that the blow gives it.
A tuned damper takes the same time for all; a cubic sink begins to pump at a threshold, a bistable
one far below it.  The dotted line is the threshold in closed form, where the slow manifold folds.
"""

import matplotlib.pyplot as plt
import numpy as np

import nlds_vines as nv

host = nv.chain([1.0], [1.0], ratio=0.001)
dampers = {
    "tuned": {"frequency_ratio": 0.98, "zeta": 0.084},
    "cubic": {"c": 0.002, "spring": nv.Spring(k3=0.44442)},
    "bistable": {"c": 0.002, "k": -0.01, "spring": nv.Spring(k3=0.44442)},
}
speeds = np.geomspace(0.01, 1.0, 25)
figure, axes = plt.subplots(figsize=(6, 3.6), layout="constrained")
for title, numbers in dampers.items():
    nes = nv.Damper("nes", attached_to="x1", m=0.02, **numbers)
    system = nv.System.from_host(host, [nes], title=title)
    vary = {"impulse": {"values": speeds.tolist()}}  # of a mass of 1 kg
    blows = nv.response_history(system, vary=vary, duration=600.0, quiet=True)
    axes.semilogx(speeds, blows["last_10"][0], ".-", label=title)
    if title == "cubic":
        axes.axvline(nv.slow_manifold(system).threshold, color="0.4", linestyle=":")
axes.set(xlabel="speed after the blow [m/s]", ylabel="time above 10 % of the energy [s]")
axes.legend()
figure.savefig("pumping.png", dpi=200)
