"""Mutants of `kernels`: scene, flight, touch, peaks, exact."""

from __future__ import annotations

from benchmarks.mutants.mutant import Mutant

_SCENE = "nlds_vines/kernels/scene.py"
_FLIGHT = "nlds_vines/kernels/flight.py"
_TOUCH = "nlds_vines/kernels/touch.py"
_PEAKS = "nlds_vines/kernels/peaks.py"
_EXACT = "nlds_vines/kernels/exact.py"
_T_TOUCH = "tests/kernels/test_touch.py::"
_T_FACTS = "tests/reference/test_exact_facts.py::"
_T_ENERGIES = "tests/reference/test_energies.py::"
_T_VARIATIONS = "tests/kernels/test_variations.py::"

MUTANTS = (
    Mutant(
        "scene: the force of a wall is left out of the damper's share",
        _SCENE,
        "return alone - pull * damper.inv_m1, alone - pull * damper.inv_mu",
        "return alone - (pull - contact) * damper.inv_m1, alone - pull * damper.inv_mu",
        ("tests/reference/test_order.py::test_free_hertz_impact",),
    ),
    Mutant(
        "scene: the dashpot of the structure is left out",
        _SCENE,
        "alone = ps.force * drive - ps.stiffness * x1 - ps.damping * v1",
        "alone = ps.force * drive - ps.stiffness * x1",
        (_T_FACTS + "test_steady_state",),
    ),
    Mutant(
        "flight: the forced response without its sine",
        _FLIGHT,
        "w[at_cell + c] = response[16 + c] * cosine + response[20 + c] * sine",
        "w[at_cell + c] = response[16 + c] * cosine",
        (_T_FACTS + "test_steady_state",),
    ),
    Mutant(
        "flight: the transition lacks what the spring's rate gives to x1",
        _FLIGHT,
        "(w[0] * x1 + w[4] * v1) + (w[8] * r + w[12] * s) + w[f],",
        "(w[0] * x1 + w[4] * v1) + (w[8] * r) + w[f],",
        (_T_FACTS + "test_defective_and_degenerate_flights",),
    ),
    Mutant(
        "flight: a share of a period takes the forcing of the first",
        _FLIGHT,
        "first = 0 if i < 4 else (i - 4) * share",
        "first = 0",
        (_T_FACTS + "test_sections_within_a_period",),
    ),
    Mutant(
        "flight: variations propagate without the last piece of a cell",
        _FLIGHT,
        "x = time / grid.h - cells",
        "x = 0.0 * time",
        (_T_VARIATIONS + "test_determinant_is_known_beforehand[two walls-exact]",),
    ),
    Mutant(
        "touch: the safe distance forgets the bend",
        _TOUCH,
        "square = slope * slope + 2.0 * bend * clearance",
        "square = slope * slope",
        (_T_TOUCH + "test_an_approach_that_speeds_up",),
    ),
    Mutant(
        "touch: a start on the wall that is pressed in is no touch",
        _TOUCH,
        "if slope > 0.0 or (slope == 0.0 and curve > 0.0):",
        "if slope > 0.0:",
        (_T_TOUCH + "test_start_on_the_wall_at_rest",),
    ),
    Mutant(
        "touch: the third derivative of a polynomial counts once",
        _TOUCH,
        "third += (k - 2.0) * part",
        "third += (k - 2.0) * part / k",
        ("tests/kernels/plain_bounds.py::test_bounds_from_the_polynomial_hold",),
    ),
    Mutant(
        "touch: the limit's greatest excess is that of the first excursion",
        _TOUCH,
        "limit_log[EXCESS] = max(limit_log[EXCESS], derivatives_at(w, x, 1.0)[0] - level)",
        "limit_log[EXCESS] = limit_log[EXCESS] or derivatives_at(w, x, 1.0)[0] - level",
        (_T_TOUCH + "test_passages_are_counted_with_the_first_and_the_deepest",),
    ),
    Mutant(
        "peaks: a factor of the damper's energy forgets the dashpot",
        _PEAKS,
        "return damper.k2, 0.0, 0.0, damper.c2, 0.0",
        "return damper.k2, 0.0, 0.0, 0.0, 0.0",
        (_T_ENERGIES + "test_the_peak_of_a_linear_transient",),
    ),
    Mutant(
        "peaks: roots of a factor are proven absent by its values alone",
        _PEAKS,
        "return alike(f, g) and (min(abs(f), abs(g)) > 0.125 * bend or abs(g - f) > bend)",
        "return alike(f, g)",
        ("tests/kernels/test_peaks.py::test_a_double_root_is_not_proven_absent",),
    ),
)
