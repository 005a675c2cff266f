"""Systems of every kind, far from the paper's, against the twin in 80-bit arithmetic.

The twin follows each orbit period by period, every time from the section that the package reports:
so chaos is examined as sharply as a steady state. What it notes, put together, must be that of the
package's one run. The error of a state is that of a single period, over how much the period
enlarges an error (at least 1), in the orbit's largest displacement and velocity.

    python -m pytest -m long tests/property/test_examination.py -o addopts="" -s
"""

from collections import Counter
from types import SimpleNamespace
from typing import NamedTuple

import numpy as np
import pytest
from support import FULL, system_of
from twin import lanes_of, model_of

from nlds_vines.engine.simulation import simulate
from nlds_vines.engine.solver_settings import SHARE

KINDS = ("none", "tmd", "ssul", "ssbl", "ssvi-b", "ssvi-c")
PERIODS = 8
NUDGE = 1e-9  # of a start, relative: what becomes of it in a period is the growth of an error
CHAOTIC = 1e7  # growth of an error in a period beyond which counts cannot be compared
TOO_SENSITIVE = "errors grow too much in a period"
STIFFEST = 400.0  # rates times the period: the twin takes about so many steps of a period
TOLERANCES = (1e-6, 1e-9, 1e-12)
ROUND_OFF = 1e-12  # of states whose parts cancel, of flights of thousands of cells
NOTHING = 1e-16  # energy of a body at rest, of which only round-off moves, beside the other's
ERRORS = ("state", "touch", "speed", "depth", "energy", "clearance", "limit")
"""Each at most the tolerance, over the growth of an error: of a state per period; times of touch,
release and first violation as places at the approach speed; the speed squared; depths relative,
with less weight where the speed is small; largest energies relative.
"""


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
    system = system_of(case.kind, case.numbers)
    numbers = dict(system.parameters) | ({"K": case.numbers["K"]} if system.scene.walls else {})
    return model_of(numbers, watched=case.kind.startswith("ssvi"))


def joined(pieces):
    """Return rows as those of `Course.contacts`, and growth, of contacts that sections have cut."""
    rows = []
    under_way = {}
    for piece in pieces:
        still = {}
        for piece_row in piece:
            wall, touch, release, _, depth, growth = piece_row
            row = under_way.get(wall) if np.isnan(touch) else None
            if row is None:
                row = list(piece_row)
                rows.append(row)
            else:
                row[2], row[4], row[5] = release, max(row[4], depth), max(row[5], growth)
            if np.isnan(release):
                still[wall] = row
        under_way = still
    return np.array(rows, float).reshape(-1, 6)


def sensitivities(states, others, size):
    """Return by contact of a lane how much a nudge of the start has grown up to there (at least 1).

    own, others: rows of the lane and of those nudged; of a contact that these lack it is infinite.
    """
    least = np.full(len(states), np.inf)
    count = min(map(len, [states, *others]))
    if count:
        apart = np.zeros(count)
        for other in others:
            touch, _, w, _ = (np.nan_to_num(states[:count] - other[:count])[:, 1:5]).T
            speed = states[:count, 3]
            parts = touch * speed / size[0], w * speed / size[1] ** 2
            apart = np.maximum(apart, np.nan_to_num(np.abs(parts)).max(0))
        least[:count] = np.maximum(1.0, np.maximum.accumulate(apart) / NUDGE)
    return least


def twin_of(cases, orbits):
    """Return what the twin saw of each case, put together, and the scales (4,) of its states.

    ends: (PERIODS, 4), each from the package's section before; growth: of an error in each period;
    contacts: rows wall, touch, release, speed, depth, growth; energies: largest E1, E2.
    """
    models, starts, sizes = [], [], []
    for case, orbit in zip(cases, orbits, strict=True):
        begun = np.vstack([case.start, np.zeros((PERIODS - 1, 4))])
        begun[1:, : orbit.section.shape[1]] = orbit.section[:-1]
        most = np.abs(begun).max(0)
        sizes += [np.array([most[::2].max(), most[1::2].max()] * 2)] * PERIODS
        starts.append(begun)
        models += [model_for(case)] * PERIODS
    starts, sizes = np.concatenate(starts), np.array(sizes)
    lanes = lanes_of(models, starts, 1)
    ends = lanes.section[:, 0]
    # what becomes of a small difference of each of the four
    nudged = starts.astype(np.longdouble) + NUDGE * np.eye(4)[:, None] * sizes
    others = lanes_of(models * 4, nudged.reshape(-1, 4), 1, noting=False)
    moved = np.abs((others.section[:, 0].reshape(4, -1, 4) - ends) / sizes).max((0, 2)) / NUDGE
    growth = np.maximum(1.0, moved.astype(float))
    seen = []
    for i, case in enumerate(cases):
        members = range(i * PERIODS, (i + 1) * PERIODS)
        courses, pieces = [lanes.course(k) for k in members], []
        period = 2 * np.pi / float(models[members[0]].omega)
        real = 1 if case.kind.startswith("ssvi") else 0
        for n, (k, course) in enumerate(zip(members, courses, strict=True)):
            rows = course.contacts
            grown = np.full(len(rows), growth[k])
            for wall in range(real, 2):
                same = rows[:, 0] == wall
                nearby = [others.course(k + m * len(starts)).contacts for m in range(4)]
                nearby = [near[near[:, 0] == wall] for near in nearby]
                grown[same] = sensitivities(rows[same], nearby, sizes[k])
            pieces.append(np.column_stack([rows + np.multiply(n * period, [0, 1, 1, 0, 0]), grown]))
        misses = np.concatenate([course.misses for course in courses])
        misses = -misses[misses[:, 0] >= real, 2]
        tops = np.max([(course.E1max, course.E2max) for course in courses], axis=0)
        mine = slice(members[0], members[-1] + 1)
        seen.append(
            SimpleNamespace(
                ends=ends[mine].astype(float), growth=growth[mine], contacts=joined(pieces),
                clearance=misses.min(initial=np.inf), energies=tops,
            )
        )  # fmt: skip
    return seen, sizes[::PERIODS]


def errors_of(case, orbit, seen, scale):
    """Return the errors of one orbit by name, or what differs in words."""
    width = orbit.section.shape[1]
    length, speed = scale[0], scale[1]
    states = np.abs(orbit.section - seen.ends[:, :width]) / scale[:width]
    # what the contacts of each period may take of the tolerance together, 1 at least
    touches = seen.contacts[~np.isnan(seen.contacts[:, 1]), 1]
    ends = np.arange(PERIODS + 1) * 2 * np.pi / case.numbers["omega"]
    crowd = np.maximum(1.0, SHARE * (np.histogram(touches, ends)[0] + 1))
    errors = {"state": (states.max(1) / seen.growth / crowd).max()}
    depths = seen.contacts[np.isfinite(seen.contacts[:, 5]), 5]
    worst = max(seen.growth.max(), depths.max(initial=1.0)) * crowd.max()
    E, least = seen.energies, NOTHING * seen.energies.max()
    errors["energy"] = abs(orbit.E1max - E[0]) / max(E[0], least) / worst
    if case.kind != "none":
        off = abs(orbit.E2max - E[1]) / max(E[1], least) / worst
        errors["energy"] = max(errors["energy"], off)
    if case.kind in ("none", "tmd"):
        return errors
    if worst > CHAOTIC * crowd.max():
        return TOO_SENSITIVE
    limited = case.kind.startswith("ssvi")
    hits = seen.contacts[seen.contacts[:, 0] == 1] if limited else seen.contacts
    hits = hits[~np.isnan(hits[:, 1])]
    rows = orbit.impacts
    if len(rows) != len(hits):
        return f"{len(rows)} impacts for {len(hits)}"
    structure = (hits[:, 0] == 0) & (case.kind == "ssbl")
    if (rows["wall"] != np.where(structure, "structure", "obstacle")).any():
        return "walls in another order"
    if (np.isnan(rows["release"]) != np.isnan(hits[:, 2])).any():
        return "another contact under way at the end"
    if len(hits):
        _, touch, release, w, depth, g = hits.T
        g = g * crowd.max()
        places = np.fmax(np.abs(rows["touch"] - touch), np.abs(rows["release"] - release))
        errors["touch"] = (places * w / length / g).max()
        errors["speed"] = (np.abs(rows["speed"] ** 2 - w**2) / speed**2 / g).max()
        over = ~np.isnan(release)
        deeper = np.abs(rows["depth"][over] / depth[over] - 1)
        errors["depth"] = (deeper * np.minimum(1, (w[over] / speed) ** 2) / g[over]).max(initial=0)
    if np.isfinite(orbit.clearance) != np.isfinite(seen.clearance):
        return f"clearance {orbit.clearance} for {seen.clearance}"
    if np.isfinite(seen.clearance):
        errors["clearance"] = abs(orbit.clearance - seen.clearance) / length / worst
    if limited:
        beyond, violation = seen.contacts[seen.contacts[:, 0] == 0], orbit.violation
        if violation.number != len(beyond):
            return f"{violation.number} violations for {len(beyond)}"
        if len(beyond):
            _, time, _, w, _, g = beyond[0]
            g *= crowd.max()
            errors["limit"] = max(
                abs(violation.time - time) * w / length / g,
                abs(violation.depth - beyond[:, 4].max()) / length / worst,
            )
    return errors


def examine(cases, tolerance):
    """Return the worst errors by name with the number of the case, and how much was seen."""
    orbits = []
    for case in cases:
        start = case.start[:2] if case.kind == "none" else case.start
        record = FULL if case.kind not in ("none", "tmd") else ("section", "energy")
        system = system_of(case.kind, case.numbers)
        orbits.append(simulate(system, PERIODS, start=start, record=record, tolerance=tolerance))
    worst, counts = dict.fromkeys(ERRORS, (0.0, -1)), Counter()
    for i, compared in enumerate(zip(cases, orbits, *twin_of(cases, orbits), strict=True)):
        errors, orbit = errors_of(*compared), compared[1]
        if isinstance(errors, str):
            counts["different" if errors != TOO_SENSITIVE else "sensitive"] += 1
            print(i, compared[0].kind, errors)
            continue
        for name, error in errors.items():
            worst[name] = max(worst[name], (float(error), i))
        counts["impacts"] += 0 if orbit.impacts is None else len(orbit.impacts)
        counts["violated"] += orbit.violation is not None and orbit.violation.number > 0
    return worst, counts


@pytest.mark.kernels
@pytest.mark.parametrize(
    ("systems", "tolerances"),
    [
        pytest.param(12, TOLERANCES, marks=pytest.mark.plain),
        *(pytest.param(2000, (tolerance,), marks=pytest.mark.long) for tolerance in TOLERANCES),
    ],
)
def test_as_the_twin_sees_it(systems, tolerances):
    """Notices: a part of a scene, a wall or a limit that is not followed as the equations say.

    Each tolerance has its share of the systems, in which most kinds are.
    """
    seen, share = Counter(), systems // len(tolerances)
    for i, tolerance in enumerate(tolerances):
        worst, counts = examine(cases_of(systems)[i * share : (i + 1) * share], tolerance)
        print(tolerance, dict(counts), *worst.items(), sep="\n")
        bound = tolerance + ROUND_OFF
        assert {name: error for name, (error, _) in worst.items() if error > bound} == {}
        seen += counts
    assert seen["different"] == 0
    assert seen["sensitive"] <= 0.02 * systems
    assert seen["impacts"] > 2 * systems
    assert seen["violated"] > systems / 20
