"""Thousands of random systems of every kind under every law and load, beside the twin of laws.

    python -m pytest -m long tests/property/test_laws.py -o addopts="" -s

A constant load, two kinds of damping, walls that let go and push again, sections inside contacts
and limits are among them. `plain_laws.py` tries a few of them each time.
"""

from collections import Counter

import pytest
from random_laws import LOADED, allowed, case_of, errors_of, errors_under_load, worst_of

from nlds_vines.model.scenes import SCENES

TOLERANCES = (1e-6, 1e-9, 1e-12)
FIXED = {"method": "rk4", "period_steps": 4096.0}  # each tenth case, to 1e-6


@pytest.mark.kernels
def test_the_largest_energy_may_stand_right_after_a_rebound(monkeypatch):
    """Of rigid bodies energies jump: here E2 is largest where the damper has just been struck."""
    monkeypatch.setitem(SCENES, LOADED.kind, LOADED)
    errors = errors_of(case_of(634), 1e-9, FIXED)
    assert errors["E2max"] < 1e-9
    assert worst_of(errors) < 1e-6


def under_a_force(i, piece_of):
    """Return the errors of a system under a harmonic force, and their bound."""
    fixed, tolerance = i // piece_of % 10 == 9, TOLERANCES[i // piece_of % 3]
    errors = errors_of(case_of(i), tolerance, FIXED if fixed else None)
    return errors, 1e-6 if fixed else allowed(tolerance)


def under_a_load(i, _):
    """Return the errors of a system under a load in time and blows, and their bound."""
    tolerance = TOLERANCES[i % 3]
    return errors_under_load(i, tolerance), allowed(tolerance)


@pytest.mark.long
@pytest.mark.parametrize(
    ("errors_and_bound", "systems", "pieces", "piece"),
    [
        *((under_a_force, 2000, 8, piece) for piece in range(8)),
        *((under_a_load, 500, 4, piece) for piece in range(4)),
    ],
)
def test_as_the_twin_sees_it(errors_and_bound, systems, pieces, piece, monkeypatch):
    """No impact is missed or invented, and all that is recorded is as the twin has it."""
    monkeypatch.setitem(SCENES, LOADED.kind, LOADED)
    count, wrong = Counter(), {}
    each = systems // pieces  # one after the other: all kinds and laws are in every piece
    for i in range(piece * each, (piece + 1) * each):
        errors, bound = errors_and_bound(i, pieces)
        count["systems"] += 1
        count["let go"] += errors.get("let go", 0.0) > 0.0
        unsure = {"chatter", "sensitive"} & set(errors)
        count["unsure"] += bool(unsure)
        if not unsure and not worst_of(errors) <= bound:
            wrong[i] = errors
    assert wrong == {}, dict(count)
    assert count["unsure"] < 0.25 * count["systems"]
    # so that walls that let go while they would pull are seen in each piece: 1.6 % in the least
    assert count["let go"] > 0.01 * count["systems"] or errors_and_bound is under_a_load, count
