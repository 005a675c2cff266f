"""The limit that scenes b and c must keep: what is reported of it, against the twin.

Number, first time and depth of the violations, random and grazing, by both methods. A difference
counts only above `FIRST` meters up to the first contact of an orbit, `LATER` behind it. Where an
excursion, or an approach that turned back, lies closer to the limit, the numbers may differ: such
orbits are counted and stay few.
"""

from collections import Counter
from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from support import BOTH, kernel_cell, run_cell_rows, system_of
from twin import follow_all, model_of

from nlds_vines.engine.records import OK, Violation
from nlds_vines.engine.simulation import simulate
from nlds_vines.errors import RequestError
from nlds_vines.model.catalog import catalog
from nlds_vines.model.system import System
from scans import computed, scan_of

pytestmark = pytest.mark.kernels

SSBL = {**catalog()["ssbl"].parameters, "K": 32504566.49525256}
METHODS = {"exact": {}, "rk4": {"method": "rk4", "period_steps": 4096.0}}
RANDOM, GRAZING = {"exact": 100, "rk4": 60}, {"exact": 60, "rk4": 40}
MANY_RANDOM, MANY_GRAZING = {"exact": 2000, "rk4": 400}, {"exact": 400, "rk4": 100}
FIRST, LATER = 1e-11, 1e-7  # resolution [m] up to and behind the first contact
FEW = 0.005  # largest share of ambiguous orbits
FAR_AWAY = 10.0  # [m], a limit that nothing below reaches

both_methods = pytest.mark.parametrize("method", METHODS)


def random_case(rng):
    """Return (kind, parameters, start, periods): everything varied, the start within the limit."""
    numbers, kind = dict(SSBL), ("ssvi-b", "ssvi-c")[rng.integers(2)]
    for name in ("m1", "k1", "c1", "m2", "k2", "c2", "P"):
        numbers[name] *= 3.0 ** rng.uniform(-1, 1)
    numbers["c2"] *= rng.choice([1.0, 0.1])
    numbers["omega"], numbers["K"] = rng.uniform(3, 12), 10.0 ** rng.uniform(5, 11)
    numbers["C"], numbers["D"] = rng.uniform(0.01, 0.15), rng.uniform(0.0, 0.1)
    numbers["L"] = rng.uniform(0.0, 0.05)
    limit = numbers["D"] + (numbers["L"] if kind == "ssvi-c" else 0.0)
    if rng.random() < 0.2:  # pressed on the obstacle, which lies within the limit or beyond it
        numbers["C"] = -limit * rng.uniform(0.5, 1.5)
    deepest = rng.random() * (75 / numbers["K"]) ** 0.4  # as an impact of 1 m/s: begun inside
    r = max(limit - rng.exponential(0.05), -numbers["C"] - deepest)
    r = min(r, limit - 1e-3)  # a contact may begin beyond the limit, a start may not
    return kind, numbers, start_of(numbers, rng, r), 3


def start_of(numbers, rng, r):
    x1, v1, s = rng.normal(0, 0.02), rng.normal(0, 0.1), rng.normal(0, 0.5)
    return np.array([x1, v1, x1 - r + numbers["D"], v1 - s])


def random_cases(rng, count):
    return [random_case(rng) for _ in range(count)]


def grazing_cases(rng, count):
    """Return cases whose limit is an extreme of r times 1 +- 1e-9 .. 1e-3."""
    cases = []
    while len(cases) < count:
        drawn = random_cases(rng, count // 2)
        for _, numbers, _, _ in drawn:
            numbers["L"] = FAR_AWAY
        free = seen_by_twin([("ssvi-c", *case[1:]) for case in drawn])
        for (_, numbers, start, periods), course in zip(drawn, free, strict=True):
            tops = course.misses[course.misses[:, 0] == 0, 2] + FAR_AWAY + numbers["D"]
            if not len(tops):
                continue
            top = rng.choice(tops)
            limit = top + rng.choice([-1, 1]) * 10.0 ** rng.uniform(-9, -3) * abs(top)
            x1, _, x2, _ = start
            if limit - numbers["D"] > 0.0 and x1 - x2 + numbers["D"] < limit:
                numbers["L"] = limit - numbers["D"]
                cases.append(("ssvi-c", numbers, start, periods))
    return cases[:count]


def seen_by_twin(cases):
    """Return the twin's course of each case; they last equally long."""
    (periods,) = {case[3] for case in cases}
    models = [
        model_of({k: v for k, v in numbers.items() if k != "L" or kind == "ssvi-c"}, watched=True)
        for kind, numbers, _, _ in cases
    ]
    return follow_all(models, [case[2] for case in cases], periods)


def verdict(orbit, course, period):
    """Return "same", "ambiguous" or what is wrong with the violations of an orbit."""
    violation, contacts = orbit.violation, course.contacts
    theirs = contacts[contacts[:, 0] == 0]
    pushes = contacts[contacts[:, 0] == 1, 1]
    behind = np.nan_to_num(pushes, nan=0.0).min(initial=np.inf)

    def resolution(times):
        return np.where(times < behind, FIRST, LATER)

    misses = course.misses[course.misses[:, 0] == 0]
    close = (theirs[:, 4] < resolution(theirs[:, 1])).any()
    close = close or (-misses[:, 2] < resolution(misses[:, 1])).any()
    if violation.number != len(theirs):
        return "ambiguous" if close else "number"
    if not len(theirs):
        return "same" if np.isnan(violation.time) and violation.depth == 0.0 else "silence"
    early = resolution(theirs[:1, 1])[0]
    if abs(violation.depth - theirs[:, 4].max()) > LATER:
        return "depth"
    rising = max(theirs[0, 3], np.sqrt(early))  # a grazing passage is located by its root
    if abs(violation.time - theirs[0, 1]) > 1e-9 * period + early / rising:
        return "time"
    return "same"


@cache
def seen(make, count):
    """Return so many cases with the twin's courses, which take longer than ours."""
    cases = make(np.random.default_rng(7), count)
    return list(zip(cases, seen_by_twin(cases), strict=True))


def outcomes(cases, options):
    """Count the outcomes of cases with the twin's courses."""
    counts = Counter()
    for (kind, numbers, start, periods), course in cases:
        orbit = simulate(system_of(kind, numbers), periods, start=start, record=BOTH, **options)
        counts[verdict(orbit, course, 2 * np.pi / numbers["omega"])] += 1
        counts["violated"] += orbit.violation.number > 0
        counts["several"] += orbit.violation.number > 1
        counts["impacts"] += len(orbit.impacts) > 0
    return counts


@both_methods
@pytest.mark.parametrize(
    ("make", "count"),
    [
        (random_cases, RANDOM),
        (grazing_cases, GRAZING),
        pytest.param(random_cases, MANY_RANDOM, marks=pytest.mark.long),
        pytest.param(grazing_cases, MANY_GRAZING, marks=pytest.mark.long),
    ],
)
def test_violations_as_the_twin_sees_them(make, count, method):
    cases = seen(make, max(count.values()))[: count[method]]
    counts = outcomes(cases, METHODS[method])
    assert counts["same"] + counts["ambiguous"] == len(cases), counts
    assert counts["ambiguous"] <= max(1, FEW * len(cases))
    for word in ("violated", "several", "impacts"):  # enough of each kind to prove something
        assert counts[word] > len(cases) / 20
    assert counts["violated"] < 0.95 * len(cases)


def test_a_wrong_report_is_seen():
    rng = np.random.default_rng(1)
    while True:
        kind, numbers, start, periods = random_case(rng)
        period = 2 * np.pi / numbers["omega"]
        orbit = simulate(system_of(kind, numbers), periods, start=start, record=BOTH)
        (course,) = seen_by_twin([(kind, numbers, start, periods)])
        if orbit.violation.number > 1 and verdict(orbit, course, period) == "same":
            break
    number, time, depth = orbit.violation
    for violation, word in (
        ((number - 1, time, depth), "number"),
        ((number, time + 1e-5, depth), "time"),
        ((number, time, depth + 1e-5), "depth"),
    ):
        wrong = replace(orbit, violation=Violation(*violation))
        assert verdict(wrong, course, period) == word


# ---- watching changes nothing --------------------------------------------------------------------


@both_methods
def test_violations_do_not_change_the_orbit_by_a_bit(method):
    """Beside a scene with the same obstacle, another wall out of reach, and no limit."""
    omegas = (5.5, 6.0, 6.3, 6.6, 7.0)
    violated = 0
    for omega in omegas:
        numbers = {**SSBL, "omega": omega}
        orbit = simulate(system_of("ssvi-b", numbers), 40, record=BOTH, method=method)
        cell = kernel_cell(**numbers, near=1e6, far=numbers["C"], rest=numbers["D"])
        section, rows = run_cell_rows(cell, np.zeros(4), 40, method)
        np.testing.assert_array_equal(orbit.section, section)
        np.testing.assert_array_equal(orbit.impacts["touch"], rows[:, 1])
        violated += orbit.violation.number > 0
    assert violated >= 4


@both_methods
def test_a_limit_out_of_reach_is_kept(method):
    """And the same orbit is followed wherever the limit is."""
    orbits = [
        simulate(system_of("ssvi-c", {**SSBL, "L": L}), 40, record=BOTH, **METHODS[method])
        for L in (0.0, 0.4, 1.0, 1e300)
    ]
    numbers = [orbit.violation.number for orbit in orbits]
    assert numbers[0] > numbers[1]
    assert numbers[2:] == [0, 0]
    for orbit in orbits:
        np.testing.assert_array_equal(orbit.section, orbits[0].section)
        assert (orbit.violation.number == 0) == np.isnan(orbit.violation.time)


def test_the_transient_counts():
    system = system_of("ssvi-b", SSBL)
    whole = simulate(system, 30, record=BOTH)
    late = simulate(system, 5, transient=25, record=BOTH)
    assert whole.violation.number > 0
    assert late.violation == whole.violation


# ---- what is refused, and what is reported -------------------------------------------------------


@pytest.mark.parametrize(("kind", "reach"), [("ssvi-b", 0.0), ("ssvi-c", 0.02)])
def test_a_start_in_violation_is_refused(kind, reach):
    system = system_of(kind, {**SSBL, "L": 0.02})
    for beyond in (0.0, 1e-9, 1.0):
        start = (0.3 + reach + beyond, 0.0, 0.3, 0.0)
        with pytest.raises(RequestError, match="in violation") as refused:
            simulate(system, 1, start=start)
        assert "\n" not in str(refused.value)
        assert f"less than {reach:g} m" in str(refused.value)
    simulate(system, 1, start=(0.3 + reach - 1e-9, 0.0, 0.3, 0.0), record=BOTH)


@pytest.mark.parametrize("kind", ["ssvi-b", "ssvi-c"])
def test_a_rest_state_in_violation_is_refused(kind):
    numbers = dict(system_of(kind, {**SSBL, "L": 0.0}).parameters)
    with pytest.raises(RequestError, match=r"D = 0\.0: a damper") as refused:
        scan_of({"kind": kind, **numbers}, ["section"], {"D": [0.0, 0.1]}).cells()
    assert "\n" not in str(refused.value)
    with pytest.raises(RequestError, match=r"D = 0\.0: a damper"):
        System(kind, {**numbers, "D": 0.0})


def lanes(policy, values):
    system = {"kind": "ssvi-b", **system_of("ssvi-b", SSBL).parameters}
    scan = scan_of(system, ["section"], values, policy, transient=20, periods=10)
    return scan, computed(scan)


@pytest.mark.plain
def test_a_lane_with_violations_is_reported_and_has_not_failed():
    scan, arrays = lanes("rest", {"omega": [5.0, 6.0, 6.3, 12.0]})
    assert (arrays["status"] == OK).all()
    assert np.isfinite(arrays["section"]).all()
    for i, omega in enumerate(scan.axes[0].values):
        orbit = simulate(scan.system.with_(omega=omega), 30, record=BOTH)
        reported = (arrays[name][i, 0] for name in ("violations", "first_violation"))
        np.testing.assert_equal(tuple(reported), orbit.violation[:2])
        assert arrays["violation_depth"][i, 0] == pytest.approx(orbit.violation.depth, rel=1e-9)
    assert (arrays["violations"][:, 0] > 0).tolist() == [True, True, True, False]


@pytest.mark.plain
@pytest.mark.parametrize("policy", ["up", "down"])
def test_a_sweep_that_carries_a_state_beyond_the_limit_says_so(policy):
    """The state at the end of a cell may violate the next cell's constraint at once."""
    far, near = 0.05, 1e-4
    scan, arrays = lanes(policy, {"D": [near, far]})
    second = 1 if policy == "up" else 0
    begun = arrays["first_violation"][second, 0]
    before = simulate(scan.system.with_(D=far), 30, record=BOTH)
    x1, _, x2, _ = before.state
    beyond = x1 - (x2 - far + near)
    assert (begun == 0.0) == (beyond > 0.0)
    assert beyond > 0.0  # so that the case is one
    assert arrays["violation_depth"][second, 0] >= beyond * (1 - 1e-9)
