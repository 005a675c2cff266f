"""Errors, impacts and failures are measured as they are; the command, as a user meets it."""

import re
import time
import tomllib
from pathlib import Path

import matplotlib.image
import numpy as np
import pytest
from contact_laws import LAWS

import nlds_vines as nv
from nlds_vines import load_scan, load_system, simulate
from nlds_vines.accuracy import measure
from nlds_vines.accuracy.measure import Result, advised, equation, measured, methods, reference
from nlds_vines.accuracy.picture import draw
from nlds_vines.engine.solver_settings import Settings

pytestmark = pytest.mark.kernels

SET6 = load_system("ssul-set6", omega=6.28)
STEEL = SET6.with_(E2=2.1e11)


@pytest.fixture(scope="module")
def confirmed():
    return reference(SET6, 6)


def result_of(confirmed, state, seconds=0.5):
    """Return the result of a method that yields a given state after a given time."""

    def follow(setting, periods, repeats):
        clock[0] += seconds
        return state

    clock = [0.0]
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(measure.time, "process_time", lambda: clock[0])
        (result,) = measured(confirmed, {"made up": ((1.0,), follow)})
    return result


def test_errors_are_those_of_the_state_and_short_runs_timed_over_more_periods(confirmed):
    result = result_of(confirmed, confirmed.state + np.array([0.0, 0.0, 2e-4, -1e-4]))
    assert result.error == pytest.approx(2e-4)
    assert result.seconds == pytest.approx(0.5 / 6)
    short = result_of(confirmed, confirmed.state, seconds=1e-3)
    assert short.seconds == pytest.approx(1e-3 / (6 * 64))


def test_periods_of_a_settled_orbit_are_timed_as_they_are_computed(confirmed):
    """A chaotic orbit never repeats, so none of its periods is copied."""
    exact = {"exact": ((1e-9,), methods(SET6, peers=False)["exact"][1])}
    (result,) = measured(confirmed._replace(periods=20), exact)
    chaotic = SET6.with_(omega=7.39)
    simulate(chaotic, 1, record=("section",))
    began = time.process_time()
    simulate(chaotic, 20_000, record=("section",))
    assert result.seconds > (time.process_time() - began) / 20_000 / 4


def test_failures_become_rows(confirmed):
    assert "not finite" in result_of(confirmed, np.full(4, np.nan)).failure
    stiff = methods(SET6.with_(K=1e30))["SciPy DOP853"][1]
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(measure, "BUDGET", 20)
        (result,) = measured(confirmed, {"SciPy": ((1e-6,), stiff)})
    assert "more than 20 evaluations" in result.failure


def test_methods_that_disagree_or_do_not_come_so_far_are_no_reference(monkeypatch, error_of):
    def other(system, periods, **settings):
        return simulate(system, periods + (settings.get("method") == "rk4"), **settings)

    monkeypatch.setattr(measure, "simulate", other)
    words = "there is no reference; measure over fewer periods"
    assert words in error_of(reference, SET6, 2)
    monkeypatch.undo()
    line = error_of(reference, SET6.with_(omega=1e-6), 2)
    assert "ssul-set6: there is no reference" in line


def test_references_are_confirmed_and_exact_keeps_its_tolerance_of_a_stiff_scene(confirmed):
    assert confirmed.uncertainty < 1e-11
    assert confirmed.growth >= 1.0
    assert confirmed.label == "T,1"
    confirmed = reference(STEEL, 5)
    exact, follow = methods(STEEL, peers=False)["exact"]
    for tolerance in (exact[3], exact[6], exact[9]):
        error = np.abs(follow(tolerance, 5) - confirmed.state).max()
        assert error <= tolerance * confirmed.growth


NOTED = ("section", "impacts", "energy")
KINDS = {
    "one wall": SET6,
    "two walls": load_system("ssbl", omega=6.05),
    "no wall": load_system("tmd", omega=6.05),
    "no damper": load_system("none", omega=6.05),
    "damped": load_system("ssul-set6", **LAWS["hunt-crossley"].constants),
    "linear": load_system("ssul-set6", **LAWS["damped"].constants),
}


@pytest.mark.parametrize("name", KINDS)
def test_scipy_converges_to_the_same_state(name):
    system = KINDS[name]
    record = NOTED if name in ("damped", "linear") else ()  # which other tests compile
    truth = simulate(system, 3, record=record).state
    follow = methods(system)["SciPy DOP853"][1]
    errors = [np.abs(follow(rtol, 3) - truth).max() for rtol in (1e-6, 1e-10)]
    assert errors[1] < min(1e-6, errors[0] / 10)


def test_impacts_that_take_no_time_are_not_for_scipy():
    assert list(methods(nv.load_system("impact-oscillator"))) == ["exact", "rk4"]
    assert list(methods(SET6, peers=False)) == ["exact", "rk4"]


def test_the_picture_joins_the_settings_that_no_other_beats(confirmed):
    numbers = ((64, 1e-3, 1.0), (128, 1e-2, 2.0), (256, 1e-5, 3.0))
    results = [Result("rk4", *one) for one in numbers]
    failed = Result("SciPy DOP853", 1e-4, failure="step too small")
    figure = draw(confirmed._replace(uncertainty=1e-15), [*results, failed])
    (line, _) = figure.axes[0].lines
    assert line.get_xdata().tolist() == [1.0, 3.0]
    names = [text.get_text() for text in figure.legends[0].get_texts()]
    assert names == ["rk4", "uncertainty of the reference"]


def test_the_cheapest_of_our_settings_is_advised():
    cheap, good = Result("exact", 1e-3, 1e-3, 1e-7), Result("rk4", 512, 1e-7, 1e-5)
    other, failed = Result("SciPy DOP853", 1e-6, 1e-9, 1e-8), Result("rk4", 64, failure="no")
    assert advised([cheap, good, other, failed], 1e-6) == good
    assert advised([cheap, good, other, failed], 1e-2) == cheap
    assert advised([cheap, good, other, failed], 1e-8) is None


def test_the_equation_is_that_of_the_motion():
    """At rest only the force acts; in a wall the contact pushes the bodies apart."""
    p = SET6.parameters
    still = equation(SET6)(0.0, 0.0, 0.0, SET6.rest, 0.0)
    assert still == pytest.approx([0.0, p["P"] / p["m1"], 0.0, 0.0])
    depth = 1e-3
    pressed = equation(SET6)(0.0, p["C"] + depth, 0.0, SET6.rest, 0.0)
    assert pressed[3] * p["m2"] == pytest.approx(p["k2"] * (p["C"] + depth) + SET6.K * depth**1.5)
    # minus the acceleration of the ground acts on both bodies
    shaken = SET6.with_(base_acceleration=0.5)
    still = equation(shaken)(0.0, 0.0, 0.0, shaken.rest, 0.0)
    assert still == pytest.approx([0.0, -0.5, 0.0, -0.5])


SHORT = ["--no-peers", "--periods", "3", "--quiet"]


@pytest.fixture
def folder(here, monkeypatch):
    """Work in an empty folder, with three settings of each method."""
    monkeypatch.setattr(measure, "EXACT", (1e-4, 1e-9, 1e-12))
    monkeypatch.setattr(measure, "RK4", (256, 512, 1024))
    return here


def test_one_command_leaves_picture_table_and_advice_that_a_scan_and_python_take(
    folder, answer, refusal
):
    output = answer("accuracy", *SHORT, "--want", "1e-6")
    rows = [line.split(" | ") for line in output.splitlines() if "| exact |" in line]
    errors = [float(row[2].strip(" <|")) for row in rows]
    assert len(errors) == 3
    assert errors == sorted(errors, reverse=True)
    assert output.count("\n| rk4 |") == 3
    assert [path.name for path in folder.iterdir()] == ["accuracy.png"]
    picture = matplotlib.image.imread("accuracy.png")
    assert picture.std() > 0.01  # something is drawn
    assert "picture 'accuracy.png' exists" in refusal("accuracy", *SHORT)
    # the advice was measured to be good enough
    (line,) = re.findall(r"^The cheapest setting with an error of at most 1e-06: .*$", output, re.M)
    assert float(re.search(r"\((\S+) at ", line).group(1)) <= 1e-6
    assert 'method = "exact"' in line
    # notices: advice in words of which a scan knows nothing
    (advice,) = re.findall(r"`(method = .*?)`", output)
    settings = tomllib.loads(advice.replace(", ", "\n"))
    scan = load_scan("ssul-set6", {"sampling": settings})
    assert scan.settings == Settings(tolerance=settings["tolerance"])
    assert simulate(load_system("ssul-set6"), 1, **settings).section.shape == (1, 4)


def test_the_middle_of_a_scan_and_a_structure_alone_are_measured_too(folder, answer):
    Path("own.toml").write_text(
        'title = "own"\nsystem = "tmd"\n[vary]\nomega = { start = 5.0, stop = 7.0, num = 3 }\n'
        '[record]\nwant = ["section"]\n'
    )
    assert "6 rad/s" in answer("accuracy", "own.toml", *SHORT)
    assert "rk4" in answer("accuracy", "--system", "none", *SHORT, "--overwrite")
