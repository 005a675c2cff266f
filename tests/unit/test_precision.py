"""Error against run time: what curves say, what is true, how surveys are kept, what is printed."""

import math
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from support import references

from nlds_vines.accuracy import comparison_page as tables
from nlds_vines.accuracy import measure, reference, survey
from nlds_vines.accuracy.cases import near_grazing, of_system, suite
from nlds_vines.accuracy.comparison_table import Measured
from nlds_vines.accuracy.contenders import Contender
from nlds_vines.accuracy.curves import Curve, above, advised, front
from nlds_vines.accuracy.reference import WITNESSES, _witnessed, reference_of, stored_section
from nlds_vines.accuracy.results import Result, Setting, column, status_column
from nlds_vines.accuracy.rivals import Course, PeerFailure
from nlds_vines.accuracy.survey import Survey, Task
from nlds_vines.archives import archive
from nlds_vines.errors import RequestError
from nlds_vines.model.catalogue import load_system
from nlds_vines.model.linear_response import steady_state
from nlds_vines.orbits.simulation import simulate
from nlds_vines.runs.interrupts import INTERRUPTED, Interrupted, Stopped

SET6 = load_system("ssul-set6", omega=6.28)


def result(value, error, seconds, *, method="rk4", ours=True, **more):
    more = {"missed": 0.0, **more}
    setting = Setting(method, value, f"{value:g} steps", ours)
    return Result(setting, error=error, seconds=seconds, **more)


def curve(points, method="rk4", doubt=1e-15, **more):
    results = tuple(result(*point, method=method, **more) for point in points)
    return Curve(method, results, doubt)


def of_order(p, method="rk4", cost=1e-6):
    """Return a curve of an exact order in the steps, at a cost in proportion to them."""
    return curve([(n, 0.1 * n**-p, cost * n) for n in (16, 32, 64, 128, 256)], method)


# ---- curves --------------------------------------------------------------------------------------


@pytest.mark.parametrize("p", [1.5, 2.5, 4.0])
def test_the_order_is_the_slope(p):
    assert of_order(p).order == pytest.approx(p, rel=1e-9)


def test_the_order_of_a_tolerance_has_its_own_sign():
    found = curve([(rtol, 3 * rtol**0.8, 1.0) for rtol in (1e-4, 1e-6, 1e-8, 1e-10)])
    assert found.order == pytest.approx(0.8)


def test_the_ends_are_no_part_of_the_law():
    """Neither round-off nor errors as large as the orbit belong to the fit."""
    lawful = [(n, 10.0 * n**-4.0, 1.0) for n in (16, 32, 64, 128)]
    spoiled = [(2, 0.5, 1.0), *lawful, (1e5, 2e-15, 1.0)]
    assert curve(spoiled).order == pytest.approx(4.0)


def test_no_order_from_two_points():
    assert math.isnan(curve([(16, 1e-4, 1.0), (32, 1e-5, 1.0)]).order)


def test_the_factor_of_a_node():
    found = curve([(n, 6.0**-n, 1.0) for n in range(6, 14)], "exact")
    assert found.factor == pytest.approx(6.0)


def test_costs_are_interpolated_by_logarithms():
    found = of_order(4.0)
    n = 100.0
    assert found.cost(0.1 * n**-4.0) == pytest.approx(1e-6 * n)


def test_costs_beyond_the_ends():
    found = curve([(1, 1e-3, 2.0), (2, 1e-6, 4.0)])
    assert found.cost(1.0) == pytest.approx(2.0)
    assert math.isinf(found.cost(1e-7))


def test_the_front_leaves_out_what_is_beaten():
    points = [(1e-3, 2.0), (1e-4, 1.0), (1e-6, 3.0), (1e-5, 5.0)]
    assert front(points) == [(1e-4, 1.0), (1e-6, 3.0)]


def test_above_names_who_is_cheaper():
    ours = curve([(1, 1e-3, 2.0), (2, 1e-13, 4.0)], "exact")
    quick = curve([(1, 1e-3, 1.0), (2, 2e-5, 8.0)], "quick")
    assert above([ours], ours) == []
    assert above([ours, quick], ours) == [("quick", 1e-3)]


def test_what_misses_touches_is_no_point():
    blind = result(8, 1e-9, 1e-9, missed=2.0)
    found = Curve("rk4", (*of_order(4.0).results, blind), 1e-15)
    assert found.points == of_order(4.0).points
    assert found.blind == [blind]
    assert found.order == pytest.approx(4.0)


def test_failures_are_no_points():
    found = curve([(1, 1e-3, 2.0)])
    failed = Curve("rk4", (*found.results, Result(found.results[0].setting, failure="no")), 1e-15)
    assert failed.points == found.points


@pytest.mark.parametrize(
    ("want", "expected"), [(None, 1.0), (1e-3, 1.0), (1e-6, 3.0), (1e-9, None)]
)
def test_the_advice_is_the_cheapest_that_is_good_enough(want, expected):
    results = [
        result(1, 1e-2, 0.5, label="T,1", missed=1.0),  # misses a touch
        result(2, 1e-2, 0.6, label="2T,1"),  # loses the label
        result(3, 1e-3, 1.0, label="T,1"),
        result(4, 1e-6, 3.0, label="T,1"),
        result(5, 1e-12, 0.1, label="T,1", ours=False),
    ]
    found = advised(results, want, "T,1")
    assert (found and found.seconds) == expected


def test_the_label_after_a_transient_is_the_final_one():
    assert advised([result(1, 1e-3, 1.0, label="T,0")], None, "transient chaos to T,0")


# ---- cases and references ------------------------------------------------------------------------


def test_the_suite_has_five_cases():
    names = [case.name for case in suite()]
    assert names == ["ssul-set6", "ssul-set6-steel", "ssbl", "near-grazing", "tmd"]


def test_near_grazing_touches_slowly():
    case = near_grazing(SET6)
    hits = simulate(case.system, 1, start=case.start).impacts
    assert len(hits) >= 1
    assert hits["speed"][0] < 0.01
    apart = case.system.with_(omega=case.system.parameters["omega"] * (1 + 2e-6))
    assert len(simulate(apart, 3, start=steady_state(apart)).impacts) == 0


@pytest.mark.parametrize("name", ["ssul-set6", "ssul-set6-steel"])
def test_stored_digits_are_found_by_their_parameters(name):
    case = next(case for case in suite() if case.name == name)
    np.testing.assert_array_equal(stored_section(case), references()[name].states[:20])


def test_no_digits_are_stored_for_another_system():
    assert stored_section(of_system(SET6.with_(c2=51.0))) is None
    assert stored_section(replace(of_system(SET6), start=(0.0, 0.0, 0.2, 0.0))) is None


def test_the_reference_agrees_with_its_witnesses():
    found = reference_of(replace(of_system(SET6.with_(c2=51.0)), periods=4))
    assert found.source == "exact, refined"
    assert found.doubt < 1e-12
    assert found.independent < 1e-10
    assert found.growth >= 1.0


def test_near_grazing_all_witnesses_agree():
    """SciPy's solver finds the touches within its steps, and plain steps are shorter than them."""
    case = near_grazing(SET6)
    found = reference_of(case)
    assert found.independent < 1e-11
    distances = {name: np.abs(s[-1] - found.section[-1]).max() for name, s in _witnessed(case)}
    assert set(distances) == set(WITNESSES)
    assert max(distances.values()) < 1e-11


def test_witnesses_that_disagree_are_told(monkeypatch):
    liars = (("naive RK4", np.ones((2, 4))),)
    monkeypatch.setattr(reference, "_witnessed", lambda case: iter(liars))
    with pytest.raises(RequestError, match="two references differ"):
        reference_of(replace(of_system(SET6), periods=2))


@pytest.mark.parametrize("column", ["touch", "E1max"])
def test_a_reference_needs_touches_and_energies_that_agree(monkeypatch, column):
    followed = reference.watched

    def other(case, **settings):
        orbit = followed(case, **settings)
        if settings.get("method") != "rk4":
            return orbit
        if column == "E1max":
            return replace(orbit, E1max=orbit.E1max * 1.01)
        return replace(orbit, impacts=orbit.impacts[:-1])

    monkeypatch.setattr(reference, "watched", other)
    with pytest.raises(RequestError, match="there is no reference"):
        reference_of(replace(of_system(SET6), periods=2))


def test_what_cannot_be_followed_has_no_reference():
    case = replace(of_system(SET6.with_(omega=1e-6)), periods=2)
    with pytest.raises(RequestError, match="ssul-set6: there is no reference"):
        reference_of(case)


def test_a_label_on_which_methods_disagree_is_none(monkeypatch):
    case = replace(of_system(SET6), periods=2)

    def judged(system, start, method="exact"):
        return SimpleNamespace(label=f"by {method}", point=None)

    monkeypatch.setattr(measure, "classify", judged)
    found = measure.truth_of(case, reference_of(case))
    assert found.label == "uncertain: by exact by exact, by rk4 by rk4"
    assert found.steady is None


# ---- measuring -----------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def truth():
    case = replace(of_system(SET6), periods=6)
    return measure.truth_of(case, reference_of(case))


def made_up(section=None, touches=None, E1max=100.0, failure=None):
    """Return a contender that finds what it is told to."""

    def follow(case, observed):
        if failure:
            raise PeerFailure(failure)
        return Course(section=section(case), touches=touches, E1max=E1max, seconds=0.5)

    return Contender(Setting("made up", 1.0, "", False), follow)


def test_errors_are_those_of_the_course(truth):
    off = truth.reference.section + np.array([0.0, 0.0, 2e-4, -1e-4])
    late = truth.reference.touches + 1e-5
    found = measure.measured(
        replace(truth, steady=None), made_up(lambda case: off, late, truth.reference.E1max + 3.0)
    )
    assert found.error == pytest.approx(2e-4)
    assert found.touch_error == pytest.approx(1e-5)
    assert found.energy_error == pytest.approx(3.0)
    assert found.missed == 0
    assert found.seconds == pytest.approx(0.5 / 6 / math.ceil(measure.SHORTEST / 0.5))


@pytest.mark.parametrize("change", [-1, 1])
def test_missed_and_invented_touches_are_counted(truth, change):
    touches = truth.reference.touches
    touches = touches[:change] if change < 0 else np.append(touches, touches[-1] + 0.1)
    contender = made_up(lambda case: truth.reference.section, touches)
    found = measure.measured(replace(truth, steady=None), contender)
    assert found.missed == -change
    assert math.isnan(found.touch_error)
    assert not found.complete


def test_one_missed_and_one_invented_are_not_the_right_number(truth):
    touches = truth.reference.touches.copy()
    touches[2] = touches[1] + 0.4 * (touches[2] - touches[1])
    contender = made_up(lambda case: truth.reference.section, touches)
    found = measure.measured(replace(truth, steady=None), contender)
    assert found.missed == 1
    assert not found.complete


def test_failures_become_rows(truth):
    assert measure.measured(truth, made_up(failure="step too small")).failure == "step too small"
    found = measure.measured(truth, made_up(lambda case: np.full((6, 4), np.nan)))
    assert "not finite" in found.failure


def test_a_label_needs_a_recurrence(truth):
    rng = np.random.default_rng(0)
    wild = made_up(lambda case: rng.normal(size=(case.periods, 4)), truth.reference.touches)
    assert measure._label(truth.steady, wild) == "undetermined"
    assert truth.label == "T,1"


# ---- surveys -------------------------------------------------------------------------------------

COLUMNS = (column("name", "str", "1", "what"), column("x", "float64", "m", "how much"))


def made_up_survey(calls, fail_at=None):
    def rows(index):
        def of():
            calls.append(index)
            if index == fail_at:
                raise Stopped
            return [{"name": f"task {index}", "x": index / 3, "status": 0}] * (index + 1)

        return of

    tasks = tuple(Task(f"{index}", rows(index)) for index in range(4))
    return Survey("Made up", "made up", {"a": 1.0}, (*COLUMNS, status_column()), tasks)


def table(path):
    with archive.read(path) as view:
        return {name: view[name].tolist() for name in view.names}


def test_a_survey_is_resumed_where_it_ended(tmp_path):
    whole, cut = tmp_path / "whole.h5", tmp_path / "cut.h5"
    survey.run(made_up_survey([]), whole)
    with pytest.raises(Interrupted) as stop:
        survey.run(made_up_survey([], fail_at=2), cut)
    assert stop.value.status == INTERRUPTED
    assert not cut.exists()
    calls = []
    survey.run(made_up_survey(calls), cut, resume=True)
    assert calls == [2, 3]
    assert table(cut) == table(whole)
    assert archive.verify(cut) == []
    assert len(table(cut)["x"]) == 10


def test_a_damaged_part_is_measured_again(tmp_path):
    path = tmp_path / "a.h5"
    with pytest.raises(Interrupted):
        survey.run(made_up_survey([], fail_at=3), path)
    part = sorted((tmp_path / "a.h5.parts").glob("*.part"))[1]
    data = bytearray(part.read_bytes())
    data[-60] ^= 1
    part.write_bytes(data)
    calls = []
    survey.run(made_up_survey(calls), path, resume=True)
    assert calls == [1, 3]


def test_what_cannot_begin_leaves_nothing(tmp_path):
    def refused():
        raise RequestError("there is no reference")

    begun = made_up_survey([])
    for count in (0, 2):
        path = tmp_path / f"{count}.h5"
        tasks = (*begun.tasks[:count], Task("refused", refused))
        with pytest.raises(RequestError, match="no reference"):
            survey.run(replace(begun, tasks=tasks), path)
        assert path.with_name(f"{count}.h5.parts").exists() is (count > 0)


def test_an_archive_is_not_touched_unasked(tmp_path):
    path = tmp_path / "a.h5"
    survey.run(made_up_survey([]), path)
    with pytest.raises(RequestError, match="exists"):
        survey.run(made_up_survey([]), path)
    calls = []
    survey.run(made_up_survey(calls), path, resume=True)  # complete: nothing to do
    assert calls == []


# ---- words ---------------------------------------------------------------------------------------


def measured_case():
    ours = curve([(4, 1e-3, 1e-6), (8, 1e-7, 2e-6), (16, 1e-13, 3e-6)], "exact", label="T,1")
    peer = curve(
        [(1e-4, 1e-3, 1e-3), (1e-10, 1e-10, 2e-3)], "SciPy DOP853, events", ours=False, label="T,1"
    )
    broken = Curve("SciPy BDF", (Result(peer.results[0].setting, failure="too stiff"),), 1e-15)
    curves = (ours, peer, replace(broken, method="SciPy BDF"))
    return Measured("a", "A case", "T,1", "stored", 1e-15, 1e-12, "me", 1.0, 20, curves)


def test_the_tables_say_what_was_measured():
    case = measured_case()
    rows = "\n".join(tables.measurements(case))
    assert "| exact | 8 steps | 1.0e-07 |" in rows
    assert "failed: too stiff" in rows
    assert tables.verdict(case) == "`exact` is the cheapest at every error from 1e-03 to 1e-12."
    assert "SciPy DOP853, events" in "\n".join(tables.ratios(case))
    advice = "\n".join(tables.advice(case, 1e-6))
    assert "nodes=8, contact_steps=20" in advice
    assert "nodes=4" in advice  # which keeps the label


def test_the_verdict_names_the_cheaper_one():
    case = measured_case()
    cheap = curve([(1, 1e-13, 1e-9)], "heyoka, events", ours=False)
    found = tables.verdict(replace(case, curves=(*case.curves, cheap)))
    assert found.startswith("Cheaper than `exact`: heyoka, events at 1e-03")


def test_the_verdict_claims_no_more_than_was_reached():
    case = measured_case()
    ours, peer, broken = case.curves
    short = replace(ours, results=ours.results[:2])  # down to 1e-7
    found = tables.verdict(replace(case, curves=(short, broken)))
    assert found == "`exact` is the cheapest at every error from 1e-03 to 1e-07."
    assert tables.verdict(replace(case, curves=(short, peer))).startswith("Cheaper than `exact`")
    failed = replace(ours, results=tuple(replace(r, failure="no") for r in ours.results))
    for curves in ((ours,), (failed, broken)):
        assert tables.verdict(replace(case, curves=curves)).startswith("Nothing can be said")
    lines = [*tables.summary(replace(case, curves=(failed, peer)))]
    lines += tables.ratios(replace(case, curves=(failed, peer)))
    assert "inf" not in "".join(lines)
    assert "| 0 |" not in "".join(lines)


def test_the_verdict_names_the_blind():
    case = measured_case()
    cheap = curve([(1, 1e-13, 1e-9)], "numbalsoda", ours=False, missed=20.0)
    found = tables.verdict(replace(case, curves=(*case.curves, cheap)))
    assert found.startswith("`exact` is the cheapest")
    assert found.endswith("Cheaper, but blind: numbalsoda with 1 steps (20 missed, 1e-13).")
    assert tables.verdict(case).endswith("1e-12.")


def test_every_table_row_has_as_many_cells_as_its_head():
    case = measured_case()
    for lines in (list(tables.measurements(case)), list(tables.summary(case))):
        assert len({line.count("|") for line in lines}) == 1


@pytest.mark.parametrize(
    ("seconds", "words"), [(2.0, "2 s"), (3.14159e-3, "3.14 ms"), (1e-6, "1 us"), (5e-9, "5 ns")]
)
def test_durations(seconds, words):
    assert tables.duration(seconds) == words
