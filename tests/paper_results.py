"""Invented results that agree with the paper, others that contradict it, and their archives."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import cache
from unittest import mock

import numpy as np

from nlds_vines.bifurcation import run as running
from nlds_vines.bifurcation.request import Scan
from nlds_vines.model.system import System
from nlds_vines.portrait.request import load_portrait
from nlds_vines.runs.run_options import RunOptions
from paper.claims import Data
from paper.claims.measured import Breadth, Motion, scan_of
from paper.linear import response
from paper.request import packaged_figures
from scans import archived, unfilled

PATTERN = ((2, 2), (3, 2), (4, 2), (1, 0), (2, 1), (0, 5))  # above T,1
SPECIAL = {
    7.375: (3, 3, "3T,3"), 7.4: (0, 90, "chaos"), 7.575: (1, 0, "transient chaos to T,0")
}  # fmt: skip
TUNED_K1 = 3.95e4  # N/m, stiffness of the structure at the tuning
TUNED = np.array([6.28])  # rad/s, frequency of the tuning


@cache
def requests():
    return packaged_figures()


def bell(omega, height, center, width=0.25):
    return height * np.exp(-(((omega - center) / width) ** 2))


def published(system, omega):
    """Return E1max as the paper has it: linear systems exactly, the others as sums of bells."""
    p = system.parameters
    if not system.scene.walls:
        return response(system, omega).E1max
    softer = 1 + 4 * max(0.0, 1 - p["k1"] / TUNED_K1) + 0.02 * (p["k1"] > TUNED_K1)
    force = (p["P"] / 800) ** 2 * (452 / p["c1"]) ** 1.2 * softer
    force *= 1 + 0.02 * abs(np.log10(p.get("E2", 2.05e7) / 2.05e7))
    if system.kind == "ssbl":
        return force**0.9 * (bell(omega, 600, 6.3) + 20)
    if p["k2"] == 215:
        return force * bell(omega, 670, 6.2)
    low = 437 if abs(p["k2"] - 669) < 1 else 480
    high = 34.0 if omega.size == 1201 else 30.0
    linear = response(system, omega).E1max
    tail = np.where(omega > 7.45, linear, high)
    return force * (bell(omega, low, 5.69) + bell(omega, 239, 6.98)) * (omega <= 7.45) + tail


def motion(system, omega):
    """Return period, impacts and label as the paper has them."""
    index = np.arange(omega.size)
    n, k = np.array([PATTERN[i % 6] for i in index]).T
    calm = (omega < 7.36) if system.kind == "ssul" else np.zeros(omega.size, bool)
    n, k = np.where(calm, 1, n), np.where(calm, 1, k)
    free = ~response(system, omega).clears & (k == 0)
    k = np.where(free, 1, k)
    words = [f"{a}T,{b}" if a else "undetermined" for a, b in zip(n, k, strict=True)]
    label = np.array(words, object)
    for place, (a, b, word) in SPECIAL.items():
        here = is_at(omega, place)
        n[here], k[here], label[here] = a, b, word
    return n, k, label


def where(place, n=None, k=None, label=None):
    """Return a function for motion as published, but for what is given where `place(...)` holds."""

    def changed(system, omega):
        before = motion(system, omega)
        there = place(system, omega, before[2])
        pairs = zip((n, k, label), before, strict=True)
        return tuple(old if new is None else np.where(there, new, old) for new, old in pairs)

    return changed


def is_at(omega, place):
    return np.abs(omega - place) < 1e-9


def is_restless(system, omega, label):
    """Any change of c1 or P turns motion into chaos, of P from lower frequencies on."""
    p = system.parameters
    return omega > (5.5 if p["P"] != 800 else (5.6 if p["c1"] != 452 else 9.0))


def everywhere(system, omega, label):
    return True


restless = where(is_restless, n=0, label="chaos")
without_period = where(everywhere, 0, 7, "6T,7")


def flat(system):
    """Return E1max where tuned of a design on a map [J]: no better than what is printed."""
    if system.kind == "ssvi-b":
        return 1500.0
    return float(published(system.with_(k2=700.0) if system.kind == "ssul" else system, TUNED)[0])


def better_design(system):
    """Return a much lower energy, the lower the less damping."""
    return (0.005 if system.kind == "ssvi-b" else 0.1) * flat(system) * system.parameters["c2"] / 50


@dataclass(frozen=True)
class MadeUp:
    """Evidence with invented results."""

    energy: Callable = published  # E1max [J] of a system by frequency
    regimes: Callable = motion  # period, impacts and label of a system by frequency
    design: Callable = flat  # E1max of a system on a map where tuned [J]
    violations: int = 0  # of the limit, on a map
    damper: float | Callable = 1.3  # its energy over the structure's, or that by frequency
    walls: float = 0.5  # share of impacts on the far one of two
    reduction: float = 0.4  # by the damper
    orbits: Callable = field(default_factory=lambda: as_published)  # of a portrait's short name
    changed: Mapping = field(default_factory=dict)  # parameters with other values

    def __call__(self, figure, name=""):
        scan = scan_of(requests()[figure], name)
        parameters = {k: value for k, value in self.changed.items() if k in scan.system.parameters}
        system = scan.system.with_(**parameters)
        axes = {axis.name: axis.values for axis in scan.axes}
        if "omega" not in axes:
            violations = np.full(scan.shape, self.violations)
            numbers = {"E1max": _map(self.design, figure), "violations": violations}
            return Data(system, axes, numbers)
        if len(axes) == 1:
            return Data(system, axes, _along(self, system, axes["omega"]))
        second = scan.axes[1]
        rows = [
            _along(self, system.with_(**{second.name: value}), axes["omega"])
            for value in second.values.tolist()
        ]
        return Data(system, axes, {key: np.stack([row[key] for row in rows], 1) for key in rows[0]})

    def motions(self, figure):
        return self.orbits(figure)


@cache
def _map(design, figure):
    scan = scan_of(requests()[figure], "")
    first, second = scan.axes
    return np.array(
        [
            [design(scan.system.with_(**{first.name: a, second.name: b})) for b in second.values]
            for a in first.values
        ]
    )


def _along(world, system, omega):
    """Return invented numbers of a system by frequency."""
    E1 = world.energy(system, omega) + np.zeros(omega.size)
    n, k, label = world.regimes(system, omega)
    damper = world.damper(omega) if callable(world.damper) else world.damper
    share = damper if system.kind == "ssul" else 0.2
    far = (k * world.walls).astype(int)
    by_wall = np.stack([k - far, far], axis=1)
    is_periodic, periods = n > 0, np.maximum(n, 1)
    return {
        "E1max": E1, "E2max": share * E1, "periodicity": n, "label": label,
        "impact_count": np.where(is_periodic, k, -1), "impact_rate": k / periods,
        "reduction": np.full(omega.size, world.reduction),
        "impacts_by_wall": np.where(is_periodic[:, np.newaxis], by_wall, -1),
        "impact_rate_by_wall": by_wall / periods[:, np.newaxis],
    }  # fmt: skip


def as_published(figure):
    """Return invented motions in a portrait as the paper has them."""
    systems = [column.system for column in load_portrait(requests()[figure].path).columns]
    random = np.random.default_rng(1).normal(size=(480, 4))
    if figure == "9":
        return [motion_in(systems[0], "3T,3", [1400.0, 10200.0, 5100.0])]
    if figure == "10":
        return [motion_in(systems[0], "", [5000.0] * 320, section=random, share=0.7, bins=2000)]
    soft = systems[0].K
    return [motion_in(s, "T,1", [3e4 if soft == s.K else 9e5], 1 / s.K) for s in systems]


def unlike_published(figure):
    """Return invented motions that contradict the paper: equal forces, lines, no way away."""
    columns = load_portrait(requests()[figure].path).columns
    label = {"9": "3T,3", "10": ""}.get(figure, "T,1")
    return [motion_in(c.system, label, [4000.0] * 3, greatest=0.05) for c in columns]


def motion_in(
    system, label, forces, duration=0.02, *, section=None, greatest=0.6, share=1e-9, bins=1000
):
    """Return a motion as of `Motion`: by default its section has three points.

    Both spectra have a `share` of their power beside the lines; `bins` hold most of it, against
    1000 in half the window.
    """
    points = np.tile(np.arange(12.0).reshape(3, 4), (80, 1)) if section is None else section
    return Motion(
        system=system, label=label, forces=np.array(forces),
        durations=np.full(len(forces), duration), section=points, least=-0.07, greatest=greatest,
        breadths=dict.fromkeys(("x2", "force"), Breadth(3, share, bins, 1000)),
    )  # fmt: skip


def write_curves(path, request, numbers):
    """Write an archive of response curves that holds these numbers of each case."""
    rows = zip(request.scans, numbers, strict=True)
    results = {scan.hash: _filled(scan, row) for scan, row in rows}
    with mock.patch.object(running, "Computer", Computed(lambda scan: results[scan.hash])):
        running.run(request, path, RunOptions(quiet=True))
    return path


def Computed(results):
    """Return a class in the place of `run.Computer` whose blocks are cut from `results(scan)`."""

    class Cut:
        def __init__(self, scan, **_):
            self.scan, self.arrays = scan, results(scan)

        def block(self, block):
            return {name: array[block.selection] for name, array in self.arrays.items()}

    return Cut


def write_figure(folder, short, evidence):
    """Write the archive of the figure of that short name, with invented numbers."""
    request = requests()[short]
    numbers = [evidence(short, name).numbers for name in request.scans]
    path = folder / request.archive
    if isinstance(request.computed, Scan):
        return archived(path, request.computed, _filled(request.computed, *numbers))
    return write_curves(path, request.computed, numbers)


def _filled(scan, numbers):
    """Return the arrays of a scan's archive with these numbers, else the fill value."""
    arrays = unfilled(scan)
    for name, array in arrays.items():
        if name in numbers:
            array[...] = np.expand_dims(numbers[name], len(scan.shape))  # the only start
        elif name == "status":
            array[...] = 0
    return arrays


# ---- worlds: in some a claim of the paper holds, in others it does not ---------------------------


def rising(system, omega):
    return omega + 40 * len(system.name) - system.parameters.get("c2", 300) * 0.1


def better(system, omega):
    """Return the published energies where the program agrees, others where it contradicts."""
    p = system.parameters
    if p.get("k2") == 2083:
        return published(system, omega) * 5
    if system.kind == "ssul":
        return published(system, omega) * 0.8
    if system.kind == "tmd" and p["k1"] < TUNED_K1:
        return published(system, omega) * (1 + 1.5 * (1 - p["k1"] / TUNED_K1))
    return published(system, omega)


def all_different(system, omega):
    """Return energies that differ from each parameter set to the next."""
    spread = 1 + 40 * (system.parameters.get("C", 0.03) - 0.03) * (system.kind == "ssul")
    return published(system, omega) * spread


def unchanging(system, omega):
    """Return energies that no change of the structure or force changes, alike in all dampers."""
    tuned = {"m1": 1000.0, "k1": TUNED_K1, "c1": 452.0, "P": 800.0, "omega": 6.28}
    shares = {"none": 1.0, "tmd": 0.42, "ssbl": 0.4}
    return published(System("none", tuned), omega) * shares.get(system.kind, 0.35)


CONTRARY = {"k1": (4.0, 1.3, 1.2), "c1": (3.0, 2.0, 1.4), "P": (1.4, 2.0, 3.0)}
"""By what the energies of SSul NES, SSbl NES and TMD grow when one parameter changes."""


def contrary(system, omega):
    """Return energies that every change makes higher, and the printed surface highest."""
    p = system.parameters
    base = bell(omega, 1500, 6.28) + 10
    if system.kind == "none":
        return base
    tuned = {"k1": TUNED_K1, "c1": 452.0, "P": 800.0}
    kind = ("ssul", "ssbl", "tmd").index(system.kind)
    growth = np.prod([f[kind] for key, f in CONTRARY.items() if p[key] != tuned[key]])
    share = (p["C"] - 0.02) * 12 if system.kind == "ssul" else 0.3
    return base * share * growth * (1 - 0.1 * abs(np.log10(p.get("E2", 2.05e7) / 2.05e7)))


RESULTS = {
    "unchanging": MadeUp(unchanging, damper=20, regimes=where(everywhere, 1, 1, "T,1")),
    "contrary": MadeUp(contrary, regimes=restless, design=better_design, reduction=-0.5),
    "chaos": MadeUp(
        regimes=where(lambda _, w, label: (w > 7.36) & (label != "3T,3"), n=0, label="chaos")
    ),
    "all_different": MadeUp(all_different),
    "published": MadeUp(),
    "better designs": MadeUp(design=better_design),
    "worse designs": MadeUp(design=lambda system: 2 * flat(system)),
    "restless": MadeUp(regimes=restless),
    "other orbits": MadeUp(orbits=unlike_published, walls=0.0, reduction=-0.5),
    "better": MadeUp(better),
    "rising": MadeUp(rising, damper=0.01, reduction=-0.5),
    "without impacts": MadeUp(regimes=where(everywhere, 1, 0, "T,0")),
    "without period": MadeUp(regimes=without_period),
    "spoiled": MadeUp(regimes=without_period, reduction=-0.5),
    "in turns": MadeUp(regimes=where(lambda _, w, label: is_at(w, 7.8), 3, 3, "3T,3")),
    "other K": MadeUp(  # T,1 everywhere with a harder contact
        regimes=where(lambda s, *_: bool(s.scene.walls) and s.K > 2.8e7, 1, 1, "T,1")
    ),
    "heavy": MadeUp(changed={"m2": 160.0, "k2": 1e8}),
}
