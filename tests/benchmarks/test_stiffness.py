"""Stiff contacts: the rigid limit, and a small survey of stiffness."""

import time
from dataclasses import replace

import numpy as np
import pytest

from benchmarks.stiffness import survey as stiffness
from benchmarks.stiffness.rigid import EXPONENT, Rigid
from benchmarks.stiffness.table import lines, page, read_stiffness, representatives
from nlds_vines.accuracy.measured_cases import Case
from nlds_vines.accuracy.picture import draw
from nlds_vines.archives import archive
from nlds_vines.errors import RequestError
from nlds_vines.kernels.impact.hertz_arc import choices_for
from nlds_vines.model.catalogue import load_system
from nlds_vines.orbits.simulation import simulate
from nlds_vines.orbits.solver_settings import Settings
from nlds_vines.runs import survey

SET6 = load_system("ssul-set6", omega=6.28)
KS = (1e10, 1e12, 1e14, 1e16)


def energy(system, state):
    """Return the energy of both masses and springs [J]."""
    p, (x1, v1, x2, v2) = system.parameters, state
    stretch = x2 - x1 - system.rest
    kinetic = p["m1"] * v1**2 + p["m2"] * v2**2
    return (kinetic + p["k1"] * x1**2 + p["k2"] * stretch**2) / 2


@pytest.mark.parametrize("name", ["ssul-set6", "ssbl"])
def test_rigid_impacts_keep_the_energy(name):
    system = load_system(name, omega=6.28, c1=0.0, c2=0.0, P=0.0)
    start = (0.0, 0.3, system.rest, 0.0)
    case = replace(Case.of(system), start=start, periods=6)
    end = Rigid(case).state()
    assert energy(system, end) == pytest.approx(energy(system, start), rel=1e-10)
    assert np.abs(end - start).max() > 0.01


def test_without_contact_the_rigid_limit_is_the_linear_motion():
    system = SET6.with_(C=100.0)
    case = replace(Case.of(system), periods=5)
    np.testing.assert_allclose(Rigid(case).state(), simulate(system, 5).state, atol=1e-12)


def test_accumulating_impacts_are_told():
    """A damper pressed on to the obstacle bounces ever faster."""
    system = SET6.with_(C=-0.05, P=0.0)
    with pytest.raises(RequestError, match="accumulate"):
        Rigid(replace(Case.of(system), start=(0.0, 0.0, 0.0, 0.0))).state()


@pytest.fixture(scope="module")
def found(tmp_path_factory):
    path = tmp_path_factory.mktemp("stiff") / "a.h5"
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(stiffness, "MODULI", (2.05e7, 2.1e13))
        patch.setattr(stiffness, "STIFFNESSES", (1e4, *KS))
        survey.run(stiffness.stiffness(SET6, 20), path)
    with archive.read(path) as view:
        return read_stiffness(view)


@pytest.mark.kernels
def test_stiffness_costs_no_accuracy(found):
    for method in ("exact", "rk4"):
        rows = found.of(method)
        assert (rows["error"] <= 1e-8 * rows["growth"]).all()
        assert (rows["missed"] == 0).all()
        assert (rows["status"] == 0).all()


@pytest.mark.kernels
def test_the_rigid_limit_is_approached_as_it_should(found):
    assert found.exponent == pytest.approx(EXPONENT, abs=0.01)


@pytest.mark.kernels
def test_steps_of_a_contact(found):
    steps = dict(zip(found.of("exact")["K"], found.of("exact")["steps"], strict=True))
    least, choices = Settings().steps, choices_for(Settings().contact_tolerance)
    assert steps[1e4] == pytest.approx(least, rel=1e-14)  # all of them are stepped
    assert steps[1e16] == min(choices)  # and none: so short that the fewest nodes do
    assert all(least * (1 - 1e-14) <= taken <= max(choices) for taken in steps.values())


def test_hard_contacts_cost_no_more_than_thrice_the_soft_ones():
    """A ratio within one run; about 1."""

    def seconds(E2):
        system, began = SET6.with_(E2=E2), time.process_time()
        simulate(system, 4000, record=["section", "impacts"])
        return time.process_time() - began

    seconds(2.05e7)  # compiles
    ratios = [seconds(2.1e13) / seconds(2.05e7) for _ in range(5)]
    assert np.median(ratios) < 3


@pytest.mark.kernels
def test_the_ratio_of_the_page_is_that_of_costs(found):
    rows = found.of("exact")
    assert found.cost_ratio == pytest.approx((rows["seconds"] / rows["seconds"][1])[1:].max())


@pytest.fixture(scope="module")
def preloaded(tmp_path_factory):
    """K given in place of moduli, no rigid limit, and a stiffness without a reference."""
    path = tmp_path_factory.mktemp("preloaded") / "a.h5"
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(stiffness, "STIFFNESSES", (1e6, 1e7))
        given = stiffness.truth_of

        def known(case):
            if case.system.K > 5e6:
                raise RequestError("there is no reference")
            return given(case)

        patch.setattr(stiffness, "truth_of", known)
        system = load_system("ssul-set6", K=2.5e7, C=-0.01)
        survey.run(stiffness.stiffness(system, 3), path)
    with archive.read(path) as view:
        found = read_stiffness(view)
        assert draw(view, methods=representatives(found)).axes
    return found


@pytest.mark.kernels
def test_without_a_rigid_limit_the_rest_is_measured(preloaded):
    rows = preloaded.of("exact")
    assert rows["K"].tolist() == [1e6, 1e7]
    assert np.isnan(rows["rigid"]).all()
    assert rows["error"][0] < 1e-8
    assert "There is no rigid limit" in "\n".join(lines(preloaded))


@pytest.mark.kernels
def test_a_stiffness_without_a_reference_fails_alone(preloaded):
    assert preloaded.of("exact")["status"].tolist() == [0, 1]
    assert "failed: there is no reference" in page(preloaded, "a.png", "command")


@pytest.mark.kernels
def test_the_page_has_every_row(found):
    text = page(found, "a.png", "command")
    assert text.count("\n| 2.1e+13 |") == 2
    table = [line for line in lines(found) if line.startswith("|")]
    assert len({line.count("|") for line in table if not line.startswith("| peer")}) <= 2


def test_the_nearest_tolerance():
    assert stiffness.nearest((1e-4, 1e-7, 1e-11)) == 1e-7
    assert stiffness.nearest((1e-4, 1e-8, 1e-10, 1e-12)) == 1e-8
