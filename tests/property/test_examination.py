"""Systems of every kind, far from the paper's, against the twin in 80-bit arithmetic.

The twin follows each orbit period by period, every time from the section that the package reports:
so chaos is examined as sharply as a steady state. Its contacts, excursions beyond the limit, near
misses and largest energies, put together, must be those of the package's one run. An error of a
state is that of a single period, divided by how much the period enlarges an error (at least 1).

Lengths are measured in the orbit's largest displacement, velocities in its largest velocity.

    python -m pytest -m long tests/property/test_examination.py -o addopts="" -s
"""

import itertools
from typing import NamedTuple

import numpy as np
import pytest
from support import FULL, system_of
from twin import lanes_of, model_of

from nlds_vines.orbits.simulation import simulate

KINDS = ("none", "tmd", "ssul", "ssbl", "ssvi-b", "ssvi-c")
PERIODS = 8
NUDGE = 1e-9  # of a start, relative: what becomes of it in a period is the growth of an error
STIFFEST = 400.0  # rates times the period: the twin takes about so many steps of a period
BOUNDS = {
    "state": 1e-8,  # error per period / growth
    "touch": 1e-8,  # times of touch and release, as places at the approach speed; / growth
    "speed": 1e-8,  # of approach, squared; / growth
    "depth": 1e-8,  # relative, where the speed is not small; / growth
    "energy": 1e-8,  # largest E1 and E2, relative; / growth
    "clearance": 1e-8,  # / growth
    "limit": 1e-8,  # time of the first violation, as a place, and depth of the deepest; / growth
}


class Case(NamedTuple):
    kind: str
    numbers: dict[str, float]
    start: np.ndarray


def decades(rng, below, above):
    return 10.0 ** rng.uniform(below, above)


def draw(rng, kind):
    """Return a random `Case`; what is not its own is ignored."""
    while True:
        p = {"m1": 1000 * decades(rng, -1.5, 1.5), "omega": 6.28 * decades(rng, -0.7, 0.7)}
        own1, own2 = 6.28 * decades(rng, -0.7, 0.7), 6.28 * decades(rng, -1, 1)
        p["m2"] = p["m1"] * decades(rng, -3, 0)
        p["k1"] = p["m1"] * own1**2
        p["k2"] = 0.0 if rng.random() < 0.05 else p["m2"] * own2**2
        p["c1"] = 0.0 if rng.random() < 0.1 else 2 * p["m1"] * own1 * decades(rng, -4, 0.3)
        p["c2"] = 0.0 if rng.random() < 0.1 else 2 * p["m2"] * own2 * decades(rng, -4, 1.3)
        reach = 0.02 * decades(rng, -1.5, 1.5)
        p["P"] = p["k1"] * reach
        p["K"] = p["m2"] * decades(rng, 1, 9)
        p["V"], p["D"] = 0.1 * decades(rng, -1, 1), reach * decades(rng, -1, 1)
        p["C"] = reach * decades(rng, -1, 1) * (-1 if rng.random() < 0.25 else 1)
        p["L"] = reach * decades(rng, -1.5, 1)
        if kind == "ssbl":
            p["C"] = max(p["C"], -0.9 * p["D"])
        x1, v1 = rng.normal(0, reach), rng.normal(0, reach * own1)
        rest = p["V"] + p["C"] if kind == "ssul" else p["D"]
        limit = p["D"] + p["L"] if kind == "ssvi-c" else p["D"]
        r = min(rng.normal(0, reach), limit - 0.1 * reach if kind.startswith("ssvi") else np.inf)
        start = np.array([x1, v1, x1 - r + rest, v1 - rng.normal(0, reach * own1)])
        if rng.random() < 0.5:
            start = np.array([0.0, 0.0, rest, 0.0])
        if kind in ("none", "tmd"):
            start[2] -= rest
        rates = own1 + p["c1"] / p["m1"] + (own2 + p["c2"] / p["m2"]) * (1 + p["m2"] / p["m1"])
        if max(rates, p["omega"]) * 2 * np.pi / p["omega"] < STIFFEST:
            return Case(kind, p, start)


def cases_of(count, seed=20251):
    rng = np.random.default_rng(seed)
    return [draw(rng, KINDS[i % len(KINDS)]) for i in range(count)]


def model_for(case):
    """Return the twin's model of a case."""
    names = {"none": "m1 k1 c1 P omega", "tmd": "m1 k1 c1 m2 k2 c2 P omega"}
    walls = {"ssul": "C V K", "ssbl": "C D K", "ssvi-b": "C D K", "ssvi-c": "C D K L"}
    chosen = names.get(case.kind, names["tmd"] + " " + walls.get(case.kind, ""))
    numbers = {name: case.numbers[name] for name in chosen.split()}
    return model_of(numbers, watched=case.kind.startswith("ssvi"))


def joined(pieces):
    """Return the rows wall, touch, release, speed, depth of contacts that sections have cut."""
    rows = []
    under_way = {}
    for piece in pieces:
        still = {}
        for wall, touch, release, speed, depth in piece:
            row = under_way.get(wall) if np.isnan(touch) else None
            if row is None:
                row = [wall, touch, release, speed, depth]
                rows.append(row)
            else:
                row[2], row[4] = release, max(row[4], depth)
            if np.isnan(release):
                still[wall] = row
        under_way = still
    return np.array(rows, float).reshape(-1, 5)


class Seen(NamedTuple):
    """What the twin saw of one orbit, put together."""

    ends: np.ndarray  # (PERIODS, 4) from the package's section before
    growth: np.ndarray  # (PERIODS,)
    contacts: np.ndarray  # rows wall, touch, release, speed, depth
    clearance: float
    energies: np.ndarray  # largest E1, E2


def twin_of(cases, orbits):
    """Return what the twin sees of each case, and the scales (4,) of its states."""
    models, starts, scales = [], [], []
    for case, orbit in zip(cases, orbits, strict=True):
        begun = np.vstack([case.start, np.zeros((PERIODS - 1, 4))])
        width = orbit.section.shape[1]
        begun[1:, :width] = orbit.section[:-1]
        size = np.abs(np.vstack([begun, begun])).max(0)
        size = np.array([size[::2].max(), size[1::2].max()] * 2)
        scales.append(size)
        starts.append(begun)
        models += [model_for(case)] * PERIODS
    starts = np.concatenate(starts)
    lanes = lanes_of(models, starts, 1)
    ends = lanes.section[:, 0]
    # what becomes of a small difference of each of the four
    size = np.repeat(scales, PERIODS, axis=0)
    nudged = starts.astype(np.longdouble) + NUDGE * np.eye(4)[:, None] * size
    others = lanes_of(models * 4, nudged.reshape(-1, 4), 1, noting=False).section[:, 0]
    moved = np.abs((others.reshape(4, -1, 4) - ends) / size).max((0, 2)) / NUDGE
    growth = np.maximum(1.0, moved.astype(float))
    seen = []
    for i in range(len(cases)):
        own = range(i * PERIODS, (i + 1) * PERIODS)
        courses = [lanes.course(k) for k in own]
        period = 2 * np.pi / float(models[own[0]].omega)
        shifts = np.arange(PERIODS)[:, None] * np.array([0.0, period, period, 0.0, 0.0])
        pieces = [c.contacts + shift for c, shift in zip(courses, shifts, strict=True)]
        real = 0 if cases[i].kind in ("ssul", "ssbl") else 1
        misses = np.concatenate([c.misses for c in courses])
        misses = -misses[misses[:, 0] >= real, 2]
        tops = np.max([(c.E1max, c.E2max) for c in courses], axis=0)
        seen.append(
            Seen(
                ends[own[0] : own[-1] + 1].astype(float),
                growth[own[0] : own[-1] + 1],
                joined(pieces),
                misses.min(initial=np.inf),
                tops,
            )
        )
    return seen, scales


def errors_of(case, orbit, seen, scale):
    """Return the errors of one orbit by name of `BOUNDS`, or what differs in words."""
    width = orbit.section.shape[1]
    growth, worst = seen.growth, seen.growth.max()
    length, speed = scale[0], scale[1]
    period = 2 * np.pi / case.numbers["omega"]

    def grown(times):
        return growth[np.clip((times / period).astype(int), 0, PERIODS - 1)]

    states = np.abs(orbit.section - seen.ends[:, :width]) / scale[:width]
    found = {"state": (states.max(1) / growth).max()}
    E = seen.energies
    found["energy"] = abs(orbit.E1max / E[0] - 1) / worst
    if case.kind != "none":
        found["energy"] = max(found["energy"], abs(orbit.E2max / E[1] - 1) / worst)
    if case.kind in ("none", "tmd"):
        return found
    limited = case.kind.startswith("ssvi")
    hits = seen.contacts[seen.contacts[:, 0] == 1] if limited else seen.contacts
    hits = hits[~np.isnan(hits[:, 1])]
    rows = orbit.impacts
    if len(rows) != len(hits):
        return f"{len(rows)} impacts for {len(hits)}"
    far = {"ssul": "", "ssbl": "obstacle"}.get(case.kind, "obstacle")
    if ((rows["wall"] == far) != (hits[:, 0] == 1)).any():
        return "walls in another order"
    if (np.isnan(rows["release"]) != np.isnan(hits[:, 2])).any():
        return "another contact under way at the end"
    if len(hits):
        g, w = grown(hits[:, 1]), hits[:, 3]
        places = [np.abs(rows["touch"] - hits[:, 1]), np.abs(rows["release"] - hits[:, 2])]
        found["touch"] = (np.nan_to_num(places) * w / length / g).max()
        found["speed"] = (np.abs(rows["speed"] ** 2 - w**2) / speed**2 / g).max()
        depth = np.abs(rows["depth"] / hits[:, 4] - 1) * np.minimum(1, (w / speed) ** 2) / g
        found["depth"] = depth[~np.isnan(hits[:, 2])].max(initial=0)
    if np.isfinite(orbit.clearance) != np.isfinite(seen.clearance):
        return f"clearance {orbit.clearance} for {seen.clearance}"
    if np.isfinite(seen.clearance):
        found["clearance"] = abs(orbit.clearance - seen.clearance) / length / worst
    if limited:
        beyond = seen.contacts[seen.contacts[:, 0] == 0]
        violation = orbit.violation
        if violation.number != len(beyond):
            return f"{violation.number} violations for {len(beyond)}"
        if len(beyond):
            first, deepest = beyond[0], beyond[:, 4].max()
            place = abs(violation.time - first[1]) * first[3] / length / grown(first[1:2])[0]
            found["limit"] = max(place, abs(violation.depth - deepest) / length / worst)
    return found


def examine(cases):
    """Return the worst errors by name, and how much was seen; fail where something differs."""
    orbits = []
    for case in cases:
        start = case.start[:2] if case.kind == "none" else case.start
        record = FULL if case.kind not in ("none", "tmd") else ("section", "energy")
        system = system_of(case.kind, case.numbers)
        orbits.append(simulate(system, PERIODS, start=start, record=record))
    seen, scales = twin_of(cases, orbits)
    worst, wrong, count = (
        dict.fromkeys(BOUNDS, (0.0, -1)),
        [],
        dict.fromkeys(("impacts", "violated"), 0),
    )
    for i, (case, orbit, one, scale) in enumerate(zip(cases, orbits, seen, scales, strict=True)):
        errors = errors_of(case, orbit, one, scale)
        if isinstance(errors, str):
            wrong.append((i, case.kind, errors))
            continue
        for name, error in errors.items():
            worst[name] = max(worst[name], (error, i))
        count["impacts"] += 0 if orbit.impacts is None else len(orbit.impacts)
        count["violated"] += orbit.violation is not None and orbit.violation.number > 0
    print(count, *worst.items(), sep="\n")
    assert not wrong
    return worst, count


@pytest.mark.parametrize("systems", [12, pytest.param(300, marks=pytest.mark.long)])
def test_as_the_twin_sees_it(systems):
    worst, count = examine(cases_of(systems))
    assert count["impacts"] > 2 * systems
    assert count["violated"] > systems / 20
    assert {name: error for name, (error, _) in worst.items() if error > BOUNDS[name]} == {}


def test_kinds_take_turns():
    kinds = [case.kind for case in cases_of(12)]
    assert kinds == list(itertools.islice(itertools.cycle(KINDS), 12))
