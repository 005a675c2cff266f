"""
Results that others have published
==================================

Nine numbers that other groups print; `scans/published-*.toml` are requests for five cases.  Budd
and Dux, Phil. Trans. R. Soc. A 347 (1994) 365, give two folds and a period doubling of an impact
oscillator.  The examples of Siconos contain reference files of an event-driven integrator,
for a ball and for an oscillator at its stop.  Weidemann, Bergman, Vakakis and Krack, Nonlinear Dyn.
(2025), doi 10.1007/s11071-025-10928-4, give the largest clearance of a VI NES at which it strikes
both walls in every period, from the slow manifold.
"""

import matplotlib.pyplot as plt
import numpy as np

import nlds_vines as nv


def special_point(omega, e, state, C, bounds, period):
    """Return the first special point of a branch along the clearance, and its system."""
    system = nv.load_system("hard-oscillator", omega=omega, e=e, C=C)
    branch = nv.continue_branch(system, "C", bounds, state, period=period, quiet=True)
    point = branch.special_points[0]
    return point, system.with_(C=point.value)


fold_2, _ = special_point(3.7, 0.8, (-2.042286327, -1.232198328), 0.33241431, (0.32, 0.36), 2)
fold_3, _ = special_point(5.6, 0.7, (-0.574498346, -0.733396283), 0.11850386, (0.115, 0.13), 3)
doubling, system = special_point(2.3, 0.6, (-0.494215316, 0.013596982), 0.178236, (0.1, 0.23), 1)
flip = nv.simulate(system, periods=1, start=tuple(doubling.state[:2]))

numbers = {"Y": 0.0, "g": 9.81, "e": 0.9, "omega": 8.0 * np.pi / 8.5}
ball = nv.simulate(nv.load_system("bouncing-ball", **numbers), periods=4, start=(1.0, 0.0))
numbers = {"m": 1e-3, "k": 100.0, "C": -9.81e-5, "e": 0.9, "P": 0.0, "omega": 100.0}
weight = nv.load_system("hard-oscillator", **numbers)
impact = nv.simulate(weight, periods=4, start=(-1.0000981, 0.0)).impacts[19]

damper = nv.load_system("vi-nes", omega=0.9885, P=0.46)
start, plane = (10.97113964, 45.40283573, 78.78155884, 75.77855383), ("omega", 0.987, 0.99)
branch = nv.continue_branch(damper, "P", (0.44, 0.47), start, period=1, plane=plane, quiet=True)
(fold,) = branch.curves
least = fold.values[:, 0].argmin()
force, omega = map(float, fold.values[least])
last = damper.with_(P=force, omega=omega)
p = last.parameters
orbit = nv.simulate(last, periods=1, start=tuple(fold.states[least]), record=["trajectory"])

rows = {
    "fold of 2T,1: clearance": (0.345147124453, fold_2.value),
    "fold of 3T,1: clearance": (0.122289075915, fold_3.value),
    "doubling of T,1: speed": (0.304271266914, flip.impacts["speed"][0]),
    "ball after 8.5 s: speed": (-4.166519586e-02, ball.state[1]),
    "oscillator: time of impact 20": (0.1936844398238720, impact["touch"]),
    "oscillator: speed of impact 20": (42.72187248905225, impact["speed"]),
    "VI NES: largest clearance": (0.33866, p["c1"] * p["k1"] * p["C"] / force),
    "VI NES: amplitude there": (0.5703, np.abs(orbit.trajectory[:, 0]).max() / p["C"]),
    "VI NES: frequency there": (0.98846, omega),
}
for name, (published, here) in rows.items():
    print(f"{name:31} {published:.12g}  {here:.12g}  {abs(here / published - 1):.0e}")

# %%
# The deviations are the digits that are printed, but for the ball: its 44 earlier impacts amplify
# the tolerance of that integrator, and here the closed form is met to 1e-12.  The slow manifold of
# the VI NES keeps one harmonic of the motion; the fold of the orbit itself lies 1 % below it.

figure, axes = plt.subplots(figsize=(6.3, 3.0), layout="constrained")
deviations = [abs(here / published - 1) for published, here in rows.values()]
axes.barh([*rows], deviations, color="#0072b2")
axes.set(xscale="log", xlabel="relative deviation from the published number", xlim=(1e-15, 1))
axes.invert_yaxis()
