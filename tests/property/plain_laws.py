"""Every contact law in all records, beside a twin that is written from the equations alone.

A few of the random cases that `test_laws.py` goes through by the thousand; run by
`contract/test_plain.py`, as each is of another sort, and would be compiled for itself.
"""

import numpy as np
import pytest
from random_laws import LOADED, Case, allowed, case_of, errors_of, worst_of
from twin_spans import Law, Model, Wall

from nlds_vines.model.scenes import SCENES
from nlds_vines.model.system import System

# Cheap ones of all kinds: by Hertz, with a limit, linear, restitution, a power, in a scene of one's
# own with a load; in case 30 a damped wall lets go.
SAMPLE = (0, 8, 9, 14, 15, 20, 25, 27, 30, 34, 50, 67, 75, 82, 90, 107, 132, 165, 172, 205)
FIXED = (8, 9, 13, 20, 25, 82, 90, 107, 140, 205, 222)
ROUGH = (13, 20, 25)  # of which


@pytest.fixture(autouse=True)
def a_scene_with_a_load(monkeypatch):
    monkeypatch.setitem(SCENES, LOADED.kind, LOADED)


@pytest.mark.parametrize("i", SAMPLE)
def test_as_the_twin_sees_it(i):
    errors = errors_of(case_of(i), 1e-9)
    assert worst_of(errors) <= allowed(1e-9), errors
    assert i != 30 or errors["let go"] > 0


@pytest.mark.parametrize("i", FIXED)
def test_fixed_steps_as_the_twin_sees_it(i):
    errors = errors_of(case_of(i), 0.0, {"method": "rk4", "period_steps": 512.0})
    assert worst_of(errors) <= (1e-4 if i in ROUGH else 1e-7), errors


@pytest.mark.parametrize("tolerance", [1e-6, 1e-12])
def test_a_wall_that_has_let_go_pushes_again(tolerance):
    """A mass leaves a stop faster than 1 / a; the spring that presses it slows it down in there."""
    p = {"m": 1.0, "k": 400.0, "c": 0.5, "P": 5.0, "omega": 40.0, "C": -0.1}
    system = System("oscillator", {**p, "K": 1e4, "hunt_crossley": 3.0})
    stop = Wall(0, 1.0, -0.1, Law("hertz", K=1e4, a=3.0))
    model = Model(1.0, 400.0, 0.5, 5.0, 40.0, walls=(stop,))
    errors = errors_of(Case(system, model, np.array([-0.05, -0.5])), tolerance)
    assert errors["pushes again"] >= 1
    assert worst_of(errors) <= allowed(tolerance), errors


def test_an_error_is_seen():
    """The twin of another mass, by a millionth."""
    case = case_of(27)
    wrong = case._replace(model=case.model.__class__(**{**vars(case.model), "m1": 1.000001}))
    assert worst_of(errors_of(case, 1e-9)) <= allowed(1e-9)
    assert worst_of(errors_of(wrong, 1e-9)) > 100 * allowed(1e-9)
