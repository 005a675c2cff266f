"""No impact is missed or invented: 10,000 random orbits, grazing ones included, against the twin.

A difference counts only above what the two integrators resolve together: `FIRST` meters of depth
(or of clearance) up to the first impact of an orbit, where both are good to round-off, `LATER`
behind it. Orbits with a smaller one are ambiguous: followed no further, counted, and few.
"""

from collections import Counter
from dataclasses import replace

import numpy as np
import pytest
from support import BOTH, NOTHING, flight_parts, follow_ssul, kernel_cell
from twin import follow, follow_all, model_of

from nlds_vines.engine.simulation import simulate
from nlds_vines.kernels.events.exact import SECTION, fly
from nlds_vines.kernels.laws.hertz import hertz_wall_at
from nlds_vines.kernels.scene.scene import Flight
from nlds_vines.model.catalog import catalog
from nlds_vines.model.scenes import SCENES
from nlds_vines.model.system import System

pytestmark = pytest.mark.kernels

SETS = [dict(catalog()[f"ssul-set{i}"].parameters) for i in range(1, 7)]
COUNTS = {"some": (500, 500, 250), "all": (8500, 1500, 1000)}
"""Random and grazing orbits, and those of both that are followed by fixed steps, too."""
FIRST, LATER = 1e-11, 1e-7  # resolution [m] of the comparison, up to and behind the first impact
NEAR = 1e-5  # two touches are the same within so many periods
FAR_AWAY = 1.0  # a gap [m] that no start below reaches
FEW = 0.002  # largest share of ambiguous orbits


def random_case(rng):
    """Return (parameters, start, periods): a Set 1-6 with everything varied, any start."""
    numbers = dict(SETS[rng.integers(len(SETS))])
    for name in ("m1", "k1", "c1", "m2", "k2", "c2", "P"):
        numbers[name] *= 3.0 ** rng.uniform(-1, 1)
    numbers["omega"], numbers["K"] = rng.uniform(3, 12), 10.0 ** rng.uniform(5, 12)
    numbers["C"] = 0.0 if rng.random() < 0.03 else rng.uniform(-0.02, 0.1)
    r = numbers["C"] - rng.exponential(0.05)
    if rng.random() < 0.03:  # begun inside a contact, as deep as an impact of 1 m/s
        r = numbers["C"] + rng.random() * (75 / numbers["K"]) ** 0.4
    return numbers, start_of(numbers, rng, r), int(rng.integers(2, 4))


def start_of(numbers, rng, r):
    """Return (x1, v1, x2, v2) with the damper's spring shortened by r."""
    x1, v1, s = rng.normal(0, 0.02), rng.normal(0, 0.1), rng.normal(0, 0.5)
    return np.array([x1, v1, x1 - r + numbers["V"] + numbers["C"], v1 - s])


def grazing_cases_of(rng, count):
    """Return cases with the gap at the twin's greatest r times 1 +- 1e-9 .. 1e-3; do they touch?"""
    cases = []
    while len(cases) < count:
        drawn = []
        for _ in range(count // 2):
            numbers, _, periods = random_case(rng)
            numbers["C"] = FAR_AWAY
            r = -rng.exponential(0.05)
            drawn.append((numbers, start_of(numbers, rng, r), periods, r))
        for (numbers, start, periods, r), free in zip(drawn, seen_by_twin(drawn), strict=True):
            if len(free.contacts) or not len(free.misses):
                continue
            top = FAR_AWAY + free.misses[:, 2].max()
            shift = rng.choice([-1, 1]) * 10.0 ** rng.uniform(-9, -3) * abs(top)
            if r < top + shift:
                numbers["C"] = top + shift
                start[2] += numbers["C"] - FAR_AWAY
                cases.append((numbers, start, periods, shift < 0))
    return cases[:count]


def seen_by_twin(cases):
    """Return the twin's course of each case (numbers, start, periods, ...)."""
    courses = {}
    for periods in {case[2] for case in cases}:
        members = [i for i, case in enumerate(cases) if case[2] == periods]
        models, starts = [model_of(cases[i][0]) for i in members], [cases[i][1] for i in members]
        courses.update(zip(members, follow_all(models, starts, periods), strict=True))
    return [courses[i] for i in range(len(cases))]


def first_difference(impacts, course, period):
    """Return "same", "ambiguous", "missed" or "invented" for the impacts of one orbit."""
    theirs = course.touches
    for k in range(max(len(impacts), len(theirs))):
        resolution = FIRST if k == 0 and len(course.contacts) == len(theirs) else LATER
        ours = impacts["touch"][k] if k < len(impacts) else np.inf
        true = theirs[k, 1] if k < len(theirs) else np.inf
        if abs(ours - true) <= NEAR * period:
            continue
        if true < ours:
            return "missed" if theirs[k, 4] > resolution else "ambiguous"
        close = np.abs(course.misses[:, 1] - ours) < 0.05 * period
        clearance = -course.misses[close, 2].max(initial=-np.inf)
        return "invented" if clearance > resolution else "ambiguous"
    return "same"


def verdicts(seen, **options):
    """Return how often each outcome occurred, of cases with the twin's courses."""
    outcomes = Counter()
    for (numbers, start, periods, *_), course in seen:
        orbit = follow_ssul(numbers, start, periods, **options)
        outcomes[first_difference(orbit.impacts, course, 2 * np.pi / numbers["omega"])] += 1
    return outcomes


@pytest.fixture(scope="module")
def random_cases():
    rng = np.random.default_rng(20240607)
    return [random_case(rng) for _ in range(COUNTS["all"][0])]


@pytest.fixture(scope="module")
def grazing_cases():
    return grazing_cases_of(np.random.default_rng(41), COUNTS["some"][1])


@pytest.fixture(scope="module", params=["some", pytest.param("all", marks=pytest.mark.long)])
def seen(request, random_cases, grazing_cases):
    """Return random cases, grazing ones, and those for fixed steps, with the twin's courses."""
    count, grazing, fixed = COUNTS[request.param]
    if grazing > len(grazing_cases):
        grazing_cases = grazing_cases_of(np.random.default_rng(42), grazing)
    first, second = (
        list(zip(cases, seen_by_twin(cases), strict=True))
        for cases in (random_cases[:count], grazing_cases)
    )
    return first, second, first[: fixed * 4 // 5] + second[: fixed // 5]


@pytest.mark.parametrize("which", ["random", "grazing", "fixed steps"])
def test_no_impact_is_missed_or_invented(which, seen):
    cases = seen[("random", "grazing", "fixed steps").index(which)]
    fixed = {"method": "rk4", "period_steps": 4096.0} if which == "fixed steps" else {}
    outcomes = verdicts(cases, **fixed)
    assert outcomes["missed"] == 0
    assert outcomes["invented"] == 0
    assert outcomes["ambiguous"] <= FEW * len(cases)
    assert outcomes.total() == len(cases)


LAWS = {
    "restitution": lambda numbers: {"law": "restitution", "e": 0.7},
    "linear": lambda numbers: {"law": "linear", "kc": 0.3 * numbers["K"], "cc": 100.0},
    "kelvin-voigt": lambda numbers: {"law": "kelvin-voigt", "kc": 0.3 * numbers["K"], "cc": 100.0},
    "power": lambda numbers: {"law": "power", "K": numbers["K"], "exponent": 1.2},
    "hunt-crossley": lambda numbers: {"K": numbers["K"], "hunt_crossley": 0.2},
}
RECORD = (*BOTH, "energy", "response")  # as beside hosts: the same kernels
OWN = SCENES["ssul"].parameter_names  # parameters beside the contact's


@pytest.mark.parametrize(
    "law",
    [
        pytest.param(law, marks=() if law in ("restitution", "linear") else pytest.mark.long)
        for law in LAWS
    ],
)
def test_the_first_touch_by_every_law(law, seen):
    """What comes before the first touch knows no law: it is that of the twin, by Hertz."""
    outcomes, touched = Counter(), 0
    for (numbers, start, periods, *_), course in seen[0] + seen[1]:
        if len(course.contacts) > len(course.touches):
            continue  # begun inside a contact
        constants = LAWS[law](numbers)
        name = constants.pop("law", "hertz")
        system = System("ssul", {own: numbers[own] for own in OWN} | constants, law=name)
        orbit = simulate(system, periods, start=start, record=RECORD)
        first = replace(course, contacts=course.contacts[:1])
        outcomes[first_difference(orbit.impacts[:1], first, system.period)] += 1
        touched += len(first.contacts)
    assert outcomes["missed"] == 0
    assert outcomes["invented"] == 0
    assert outcomes["ambiguous"] <= FEW * outcomes.total()
    assert 0.3 < touched / outcomes.total() < 0.9


def test_a_missed_and_an_invented_impact_are_seen(random_cases):
    numbers, start, periods = next(
        case for case in random_cases if len(follow(model_of(case[0]), *case[1:]).touches) > 1
    )
    period = 2 * np.pi / numbers["omega"]
    course = follow(model_of(numbers), start, periods)
    impacts = follow_ssul(numbers, start, periods).impacts
    assert first_difference(impacts, course, period) == "same"
    assert first_difference(impacts[:-1], course, period) == "missed"
    twice = np.sort(np.append(impacts, impacts[-1:]), order="touch")
    twice["touch"][-1] += 0.01 * period
    assert first_difference(twice, course, period) == "invented"


def touches(numbers, start, periods, certified=True):
    """Return True if the exact flight meets the wall; without the certificate it tests ends only.

    The bounds of d2r/dt2 rest on `grid.bend` and the forcing alone; the flight itself is tabulated.
    """
    ps, damper, grid = flight_parts(**numbers)
    wall = hertz_wall_at(numbers["C"], damper.inv_mu, kernel_cell(**numbers))
    if not certified:
        ps, grid = ps._replace(force=0.0), grid._replace(bend=0.0)
    x1, v1, x2, v2 = start
    y = x1, v1, x1 - x2 + numbers["V"] + numbers["C"], v1 - v2
    for _ in range(periods):
        flight = Flight(None, ps, damper, wall, None, grid)
        event, _, _, *y = fly(flight, NOTHING, (0, 0.0), grid.n, tuple(y))
        if event != SECTION:
            return True
    return False


def test_without_its_certificate_the_flight_misses_grazing_impacts(grazing_cases):
    sure = [case[:3] for case in grazing_cases if case[3]]
    assert all(touches(*case) for case in sure)
    missed = sum(not touches(*case, certified=False) for case in sure)
    assert missed > len(sure) / 10
