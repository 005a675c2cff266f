"""
Localized motion of a cyclic chain
==================================

Ten equal oscillators in a ring, each with a ball in a cavity: the host of Weidemann, Bergman,
Vakakis and Krack, Nonlinear Dyn. (2025), doi 10.1007/s11071-025-10928-4.  Their parameters for
Figures 19 and 21 (top), as their public configuration files print them: mass ratio 0.02, damping
ratio 0.001, coefficient of restitution 0.8, coupling 0.002, the clearance 0.33 of the amplitude at
resonance, equal forces in phase; in Figure 21 the frequency is 0.993297.  Balls of some oscillators
strike both walls in every period, the others rest.
"""

import matplotlib.pyplot as plt
import numpy as np
import scipy.linalg

import nlds_vines as nv

N, EPS, D, E, COUPLING, GAMMA = 10, 0.02, 1e-3, 0.8, 0.002, 0.33
m, gap = 1 - EPS, GAMMA / (2 * D)
# the damping ratio is that of the chain with balls that stick to it
ring = nv.chain([m] * N, [COUPLING] * N, grounds=1.0, cyclic=True, ratio=D / np.sqrt(m))
C = ring.M @ ring.modes @ np.diag(2 * D / np.sqrt(m) * ring.frequencies) @ ring.modes.T @ ring.M
walls = [nv.Wall(gap, side, law="restitution", e=E) for side in "+-"]
balls = [nv.Damper(f"ball{i}", dof, m=EPS, walls=walls) for i, dof in enumerate(ring.dofs)]
force = dict.fromkeys(ring.dofs, 1.0)


def system(r):
    return nv.System.from_host(ring, balls, force=force, omega=r)


# %%
# Two closed forms of the motion in which some balls strike in every half period; they are those of
# one oscillator, or of others that are its images by symmetry.  The published one balances the
# first harmonic.  The other joins two half periods of the whole linear chain, as Masri and Caughey
# (J. Appl. Mech. 33, 1966, 586) did for one oscillator, and is exact.


def receptance(r):
    return np.linalg.inv(ring.K - r**2 * ring.M + 1j * r * C)


def published(xi, r, strikers=(0,)):
    """Return the clearance over the amplitude at resonance; xi: amplitude over the clearance."""
    H, rho = receptance(r), 2 / np.pi * (1 - E) / (1 + E)
    theta = (1 + np.sqrt((1 + rho**2) * xi**2 - rho**2)) / (1 + rho**2)
    push = -8 * EPS / np.pi**2 * r**2 * theta * (theta - 1 - 1j * rho * theta) / xi
    return 2 * D * np.abs(H[0].sum() / (xi + H[0, list(strikers)].sum() * push))


def exact(r, strikers=(0,)):
    """Yield of each exact motion its amplitude (first harmonic) over the clearance, and a start."""
    H, T, strikers = receptance(r), 2 * np.pi / r, np.array(strikers)
    Q, kick = H.sum(axis=0), np.zeros(2 * N)
    kick[N + strikers] = 2 * EPS / m
    A = np.block([[np.zeros((N, N)), np.eye(N)], [-ring.K / m, -C / m]])
    half = scipy.linalg.expm(A * T / 2)
    before = np.linalg.solve(np.eye(2 * N) + half, half @ kick)  # an impact, for the speed 1
    alpha = T / 4 + before[0]
    beta = ((1 - E + 2 * EPS / m) / (1 + E) - before[N]) / r
    speeds = np.roots([alpha**2 + beta**2, -2 * gap * alpha, gap**2 - abs(Q[0]) ** 2])
    for u in speeds[np.isreal(speeds)].real:
        turn = (gap - alpha * u - 1j * beta * u) / Q[0]  # exp(i r t) at the impact
        first = Q[0] - 8 * EPS * u / T * H[0, strikers].sum() / turn
        count, flown = divmod(-np.angle(turn) / r % T, T / 2)  # impacts since, time of flight
        u *= (-1) ** count
        chain = scipy.linalg.expm(A * flown) @ (before - kick) * u
        chain += np.concatenate([Q.real, (1j * r * Q).real])
        rest = np.zeros((N, 2))
        rest[strikers] = u * (flown - T / 4), u
        yield abs(first) / gap, np.concatenate([chain.reshape(2, N).T, rest])


r = 0.985
for xi, start in exact(r):
    orbit = nv.simulate(system(r), 1, start=start.ravel(), quiet=True)
    error = np.abs(orbit.state - start.ravel()).max() / gap
    print(f"amplitude {xi:.4f} clearances, after a period off by {error:.0e}")
    print(f"  published clearance for it: {published(xi, r):.4f} in place of {GAMMA}")


# %%
# Harmonic balance is 1.5 % above the exact clearance.  The upper motion attracts; from 0.9893 on it
# has lost its symmetry, which both closed forms assume.


def settled(r, start, transient=1000, periods=32):
    """Return the amplitudes over the clearance, and impacts of each ball per period."""
    record = ["trajectory", "impacts"]
    orbit = nv.simulate(
        system(r), periods, start=start.ravel(), transient=transient, record=record, quiet=True
    )
    x, names = orbit.trajectory[:, : 2 * N : 2], [ball.name for ball in balls]
    first = 2 * np.abs(np.exp(-1j * r * orbit.time) @ x) / len(x)
    rates = [np.sum(orbit.impacts["damper"] == name) / periods for name in names]
    return first / gap, np.array(rates)


# %%

figure, (left, right) = plt.subplots(
    1, 2, figsize=(9.5, 3.6), layout="constrained", width_ratios=[1.2, 1]
)
frequencies, amplitudes = np.linspace(0.98, 0.998, 181), np.linspace(0.3, 1.3, 201)
levels = np.array([published(amplitudes, r) for r in frequencies])
left.contour(frequencies, amplitudes, levels.T, [GAMMA], colors="0.6")
left.plot([], [], "0.6", label="published, one harmonic")
motions = [(r, xi) for r in frequencies for xi, _ in exact(r)]
left.plot(*np.transpose(motions), ".", ms=2, label="exact")
for r in np.linspace(0.983, 0.996, 14):
    xi, start = max(exact(r), key=lambda motion: motion[0])
    left.plot(r, settled(r, 1.001 * start)[0][0], "ko", ms=4, mfc="none")
left.plot([], [], "ko", ms=4, mfc="none", label="settled orbits")
left.set(xlabel="frequency", ylabel="amplitude / clearance", xticks=[0.98, 0.985, 0.99, 0.995])
left.legend(loc="upper left")

# %%
# At their frequency, some neighbors are started with the motion above, and the others at rest.

r, rates = 0.993297, []
xi, start = max(exact(r), key=lambda motion: motion[0])
for count in range(1, N):
    chosen = np.where(np.arange(N) < count, 0, N // 2)
    rates.append(settled(r, start[np.concatenate([chosen, N + chosen])], transient=600)[1])
    print(f"{count} strike at first; impacts per period {np.round(rates[-1], 1)}")

image = right.imshow(np.transpose(rates), extent=(0.5, N - 0.5, N + 0.5, 0.5), vmin=0, vmax=2)
right.set(xlabel="neighbors that strike at first", ylabel="oscillator", aspect="auto")
figure.colorbar(image, ax=right, label="impacts per period")

# %%
# One or two neighbors go on for good; three or more lose the 1:1 motion and move irregularly, with
# 1 to 1.5 impacts per period, and the others do not notice.  Of the 106 patterns of a ring of ten,
# up to rotation, the 47 without three neighbors in a row last, and no other
# (`tests/kernels/test_cyclic_chain.py`).
