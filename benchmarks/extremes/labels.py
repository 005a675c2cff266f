"""What is said about an orbit: exponents, phase, labels (entries 19, 20 and 21)."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from benchmarks.extremes.cases import BOTH, LINEAR, amplitudes, error_of, shortening
from benchmarks.extremes.entry import Entry, Finding, within
from nlds_vines import classify, simulate
from nlds_vines.kernels.cells.verdict import SMOOTH_DIGITS
from nlds_vines.kernels.orbit.growth import digits_of, mean_and_width
from nlds_vines.kernels.orbit.recurrence import TOLERANCE, period_of
from nlds_vines.model.catalogue import load_system
from nlds_vines.model.linear_response import steady_state
from nlds_vines.model.system import System

GOLDEN = (math.sqrt(5.0) - 1.0) / 2.0
MANY = 1_000_000  # forcing periods


def _trace(system: System) -> float:
    """Return the rate [1/s] at which volumes of states grow: -(c1 + c2)/m1 - c2/m2."""
    p = {"m2": 1.0, "c2": 0.0, **system.parameters}
    return -(p["c1"] + p["c2"]) / p["m1"] - p["c2"] / p["m2"]


def _cases() -> Mapping[str, System]:
    return {
        "T,1": load_system("ssul-set6"),
        "T,1 on steel": load_system("ssul-set6", K=1e12),
        "soft": load_system("ssul-set6", K=1e4),
        "7.45 rad/s": load_system("ssul-set6", omega=7.45),
        "two walls": load_system("ssbl", omega=6.05),
        "preloaded": load_system("ssul-set6", C=-0.001),
        "no wall": load_system("tmd"),
        "no damper": load_system("none"),
        "chaos": load_system("ssul-set6", m2=1e4),
    }


def volumes() -> Finding:
    """Sum up exponents and multiply Floquet multipliers of orbits of several kinds."""
    sums, products, labels = {}, {}, set[str]()
    for name, system in _cases().items():
        found, trace = classify(system), _trace(system)
        labels.add(found.kind)
        sums[name] = abs(found.exponents.sum() / trace - 1.0)
        if found.multipliers is not None:
            expected = math.exp(found.period * system.period * trace)
            products[name] = abs(found.multipliers.prod() / expected - 1.0)
    one, two = (max(table, key=table.__getitem__) for table in (sums, products))
    words = (
        f"{len(sums)} orbits ({', '.join(sorted(labels))}): the sum is off by {sums[one]:.1e} at "
        f"most ({one}), the product by {products[two]:.1e} ({two})"
    )
    enough = len(labels) > 1 and len(products) > 3
    return within(max(sums[one], products[two]) if enough else math.nan, 1e-8, words)


def phase_in_flight() -> Finding:
    """Follow the steady motion without contact for 1e6 periods; it is known in closed form."""
    worst = 0.0
    for system in (load_system("tmd"), load_system("ssul-set6", omega=9.0)):
        start = steady_state(system)
        record = BOTH if system.scene.walls else LINEAR
        orbit = simulate(system, 8, start=start, transient=MANY, record=record)
        exact, like = np.tile(start, (8, 1)), amplitudes(system)
        worst = max(worst, error_of(orbit.section, exact, like=like))
        if system.scene.walls and shortening(system) >= system.parameters["C"]:
            return within(math.nan, 1e-12, "the motion touched the wall")
    return within(worst, 1e-12, f"after 1e6 periods the section is {worst:.1e} off")


def phase_with_impacts() -> Finding:
    """Compare section and touches of periodic orbits after 1e6 periods with those after 1e3."""
    worst, late = 0.0, 0.0
    for system in (load_system("ssul-set6"), load_system("ssul-set6", K=1e12)):
        early, after = (
            simulate(system, 48, transient=transient, record=BOTH) for transient in (1000, MANY)
        )
        assert early.impacts is not None
        assert after.impacts is not None
        if len(early.impacts) != len(after.impacts) or len(early.impacts) == 0:
            return within(math.nan, 1e-9, "the impacts differ in number")
        worst = max(worst, error_of(after.section, early.section, system.rest or 0.0))
        passed = (MANY - 1000) * system.period
        shift = np.abs(after.impacts["touch"] - early.impacts["touch"] - passed).max()
        late = max(late, float(shift) / system.period)
        rising = np.diff(after.impacts["touch"]).min() > 0.0
        if not rising or np.nanmin(after.impacts["release"] - after.impacts["touch"]) <= 0.0:
            return within(math.nan, 1e-9, "times of impacts do not ascend")
    words = f"after 1e6 periods states are {worst:.1e} off, instants {late:.1e} periods"
    return within(max(worst, late), 1e-9, words)


# ---- sequences whose nature is known beforehand ------------------------------------------------


def logistic(r: float, count: int, skip: int = 500) -> tuple[np.ndarray, np.ndarray]:
    """Return an orbit of x -> r x (1 - x), and the logarithms of its growth per iteration."""
    x, orbit = 0.3, np.empty(count)
    for i in range(-skip, count):
        x = r * x * (1.0 - x)
        if i >= 0:
            orbit[i] = x
    return orbit, np.log(np.abs(r * (1.0 - 2.0 * orbit)))


def torus(count: int, rotation: float = GOLDEN) -> np.ndarray:
    """Return a smooth function along a rotation."""
    angle = 2.0 * math.pi * rotation * np.arange(count)
    return np.exp(np.cos(angle)) * np.sin(angle + 0.3)


def noise(count: int, seed: int) -> np.ndarray:
    """Return independent normal numbers."""
    return np.random.default_rng(seed).normal(size=count)


def _period(values: np.ndarray) -> int:
    """Return the period that is seen in a section made of one sequence."""
    return int(period_of(np.stack([values, values**2], axis=-1), TOLERANCE))


def periods_of_sequences() -> Finding:
    """Look for the period of sequences that have one, and of sequences that have none."""
    length, wrong, count = 120, 0, 0
    for n in range(1, 41):
        base = np.random.default_rng(n).uniform(1.0, 2.0, size=n)
        periodic = np.resize(base, length)
        for values, period in (
            (periodic, n),
            (periodic * (1.0 + 1e-9 * noise(length, n)), n),
            (periodic * (1.0 + 1e-3 * noise(length, n)), 0),
        ):
            wrong, count = wrong + (_period(values) != period), count + 1
    aperiodic = [noise(length, seed) for seed in range(20)]
    aperiodic += [torus(length, r) for r in (GOLDEN, math.sqrt(2.0), 1.0 / math.pi, 1e-3)]
    aperiodic += [logistic(r, length)[0] for r in (3.7, 3.9, 4.0)]
    for values in aperiodic:
        wrong, count = wrong + (_period(values) != 0), count + 1
    words = f"{count} sequences, of period 1 to 40, with noise, on tori, chaotic: {wrong} misjudged"
    return within(wrong, 0.0, words)


def natures_of_sequences() -> Finding:
    """Tell chaos, tori and noise apart by growth rates and by how averages converge."""
    count, wrong, tried = 2400, 0, 0
    for r in (3.7, 3.9, 4.0):
        orbit, logs = logistic(r, count)
        mean, width = mean_and_width(logs)
        wrong += not mean - width > 0.0 or digits_of(orbit) >= SMOOTH_DIGITS
        tried += 1
    wrong += not abs(mean - math.log(2.0)) <= width  # the exponent of the last one is ln 2
    for r in (3.2, 3.5, 3.55, 3.83):
        mean, width = mean_and_width(logistic(r, count)[1])
        wrong, tried = wrong + (not mean + width < 0.0), tried + 1
    for rotation in (GOLDEN, math.sqrt(2.0), 1.0 / math.pi):
        smooth = torus(count, rotation)
        wrong += digits_of(smooth) < SMOOTH_DIGITS
        wrong += digits_of(smooth + 1e-2 * noise(count, 1)) >= SMOOTH_DIGITS
        tried += 2
    for seed in range(20):
        wrong, tried = wrong + (digits_of(noise(count, seed)) >= SMOOTH_DIGITS), tried + 1
    return within(wrong, 0.0, f"{tried} sequences of known nature: {wrong} misjudged")


def labels_of_linear_motion() -> Finding:
    """Label motions without contact, whose nature follows from their frequencies alone."""
    free = {"c1": 0.0, "c2": 0.0}
    rational = {"m1": 1000.0, "k1": 4000.0, "c1": 0.0, "omega": 1.0}
    expected = {
        "damped": (load_system("tmd"), ["T,0"]),
        "hardly damped": (load_system("none", c1=40.0), ["T,0"]),
        "two undamped modes": (load_system("tmd", omega=4.0, **free), ["quasiperiodic"]),
        "an undamped mode": (load_system("none", omega=4.0, c1=0.0), ["quasiperiodic"]),
        "a slow beat": (load_system("none", c1=0.0), ["quasiperiodic", "undetermined"]),
        "a mode of half the period": (load_system("none", **rational), ["undetermined"]),
        "at rest, undamped": (load_system("tmd", P=0.0, **free), ["undetermined"]),
    }
    found = {name: classify(system).label for name, (system, _) in expected.items()}
    wrong = [name for name, (_, labels) in expected.items() if found[name] not in labels]
    words = "; ".join(f"{name}: {label}" for name, label in found.items())
    return within(len(wrong), 0.0, words)


ENTRIES = (
    Entry(
        19,
        "volumes",
        "Exponents sum up to the trace -(c1 + c2)/m1 - c2/m2, and Floquet multipliers multiply to "
        "exp(n T trace), across contacts of every kind, to 1e-8.",
        volumes,
    ),
    Entry(
        20,
        "phase in flight",
        "After 1e6 periods the section is the closed form to 1e-12: periods are counted, never "
        "summed up.",
        phase_in_flight,
    ),
    Entry(
        20,
        "phase with impacts",
        "After 1e6 periods a periodic orbit with impacts is the one it was after 1e3, its touches "
        "in place and ascending.",
        phase_with_impacts,
        "A time of 1e6 periods is itself a number of 16 digits: its last one is 1e-10 periods.",
    ),
    Entry(
        21,
        "periods of sequences",
        "Made-up sections of period 1 to 40, quasi-periodic, chaotic or noisy, get the exact "
        "period, or none.",
        periods_of_sequences,
    ),
    Entry(
        21,
        "natures of sequences",
        "Chaos needs a growth rate above its interval, a torus smooth averages; noise is neither.",
        natures_of_sequences,
    ),
    Entry(
        21,
        "labels of linear motion",
        "Motions without contact, damped or not, get the label that their frequencies demand, or "
        "undetermined.",
        labels_of_linear_motion,
        "Undamped periodic motions attract nothing, and `periodic` means an orbit that does: they "
        "stay undetermined. So does a beat that is slow beside the periods watched.",
    ),
)
