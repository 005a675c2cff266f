"""An orbit that goes on from its kept state is the orbit that was never stopped.

Random systems of every kind under every law are followed in one call and period by period. (Run by
`contract/test_plain.py`, as each is of another sort, and would be compiled for itself.)
"""

import numpy as np
import pytest
from random_laws import LOADED, case_of

from nlds_vines.engine.batch import start_state
from nlds_vines.engine.kind_engine import Beginning
from nlds_vines.engine.solver_settings import Settings
from nlds_vines.kernels.orbit.orbit import STATE_AHEAD, STATE_SIZE
from nlds_vines.kernels.scene.codes import FLYING
from nlds_vines.model.catalog import load_system
from nlds_vines.model.scenes import SCENES

RECALLED = 2e-11  # relative change of what is noted inside an impact that nearly equals one before
CASES, PERIODS = 90, 3  # each kind under each law


@pytest.fixture(autouse=True)
def a_scene_with_a_load(monkeypatch):
    monkeypatch.setitem(SCENES, LOADED.kind, LOADED)


def beginning(system, start=None):
    state = start_state(system, system.cell.rest, start)
    return Beginning(system, "exact", Settings.of("exact"), system.cell, state)


def compare(begin, periods):
    """Compare an orbit with its single periods; return how many of them begin inside an impact."""
    record = ("section", "impacts") if begin.system.scene.walls else ("section",)
    orbit, rows, inside = begin.follow(record, 0, periods), [], 0
    for p in range(periods):
        one = begin.follow(record, 0, 1)
        begin = begin.after(1)
        is_solved = begin.state[5] != FLYING and begin.state[STATE_AHEAD] > 0.0
        inside += is_solved
        if is_solved:  # what the section notes is stepped beside the orbit, and recalled
            scale = np.abs(orbit.section).max(axis=0)
            assert np.all(np.abs(one.section[0] - orbit.section[p]) <= RECALLED * scale)
        else:
            assert one.section[0].tobytes() == orbit.section[p].tobytes()
        if one.impacts is not None:
            table = one.impacts.copy()
            table["touch"] += p * begin.system.period
            table["release"] += p * begin.system.period
            rows.append(table)
    if rows:
        compare_impacts(np.concatenate(rows), orbit.impacts)
    return inside


def compare_impacts(pieces, whole):
    """Compare tables of impacts; one that a section cuts has no release in the pieces."""
    assert pieces["wall"].tolist() == whole["wall"].tolist()
    is_whole = ~np.isnan(pieces["release"])
    for name in pieces.dtype.names[1:]:
        rows = pieces[name] != whole[name]  # forces of an instantaneous impact are infinite
        if name not in ("touch", "speed"):
            rows &= is_whole
        apart = np.abs(pieces[name][rows] - whole[name][rows]).max(initial=0.0)
        assert apart <= RECALLED * np.nanmax(np.abs(whole[name]), initial=0.0), (name, apart)


@pytest.mark.parametrize("i", range(CASES))
def test_period_by_period(i):
    case = case_of(i)
    compare(beginning(case.system, case.start), PERIODS)


@pytest.mark.parametrize("name", ["ssul-set6", "ssbl"])
def test_inside_impacts_that_are_solved(name):
    assert compare(beginning(load_system(name, omega=6.05)), 40) > 0


def test_the_kept_state_has_the_impact_under_way():
    begin = beginning(load_system("ssul-set6", omega=6.05))
    for _ in range(40):
        begin = begin.after(1)
        if begin.state[STATE_AHEAD] > 0.0:
            break
    stepped = begin.state.copy()
    stepped[STATE_AHEAD:STATE_SIZE] = 0.0
    # an impact that is stepped anew from the section ends elsewhere, within the tolerance
    other = begin._replace(state=stepped).after(1).state
    assert other.tobytes() != begin.after(1).state.tobytes()
