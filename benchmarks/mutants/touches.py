"""Mutants: the walk to a touch and past a near miss, bounds, short and stepped contacts in depth."""

from __future__ import annotations

from benchmarks.mutants.mutant import of

_T_EXACT = "tests/kernels/plain_exact.py::"
_T_FLIGHT = "tests/kernels/plain_flight.py::"
_T_TOUCH = "tests/kernels/plain_touch.py::"
_T_IMPACT = "tests/kernels/plain_impact.py::"
_T_CONTACT = "tests/kernels/plain_contact.py::"
_T_CONTACT_ERROR = "tests/kernels/test_contact_error.py::"
_WHICH_CELLS = _T_EXACT + "test_which_cells_may_hold_a_closer_miss"
_EITHER_WALL = _T_EXACT + "test_a_near_miss_of_either_wall"
_PARTS = _T_FLIGHT + "test_each_part_of_the_bounds_is_needed"
_RATE = _T_FLIGHT + "test_the_rate_is_the_largest_row_sum_or_the_forcing"
_BEND = _T_FLIGHT + "test_the_bend_is_the_largest_second_derivative_at_energy_scale_one"

MUTANTS = (
    *of(
        "nlds_vines/kernels/events/exact.py",
        (
            "exact: the far wall is touched first whenever it is touched",
            "        if other <= end and other < place:",
            "        if other <= end:",
            _T_EXACT + "test_the_first_of_two_walls_in_one_cell",
        ),
        (
            "exact: the later of two walls is touched first",
            "        if other <= end and other < place:",
            "        if other <= end and other > place:",
            _T_EXACT + "test_the_first_of_two_walls_in_one_cell",
        ),
        (
            "exact: what the forcing brings about in some cells is not expected",
            "        ahead = bound.push * grid.h * (last - j)",
            "        ahead = 0.0",
            _T_FLIGHT + "test_a_touch_that_the_forcing_brings_about_after_some_cells",
        ),
        (
            "exact: a wall that is missed on the way to the other is not noted",
            "and (event != SECTION or may_hold_a_miss(near, far, clearance, r, y[2], slack))",
            "and event == SECTION and may_hold_a_miss(near, far, clearance, r, y[2], slack)",
            "tests/kernels/plain_exact.py::test_a_wall_is_missed_on_the_way_to_the_other[exact]",
        ),
        (
            "exact: near misses of the far wall are those of the near one",
            "nearest_miss(grid.table, 0.0, -1.0, end, best, bend, jerk, touches)",
            "nearest_miss(grid.table, 0.0, 1.0, end, best, bend, jerk, touches)",
            _EITHER_WALL,
        ),
        (
            "exact: near misses of the far wall are not noted",
            "            clearance[0] = far.gap - top\n",
            "            pass\n",
            _EITHER_WALL,
        ),
        (
            "exact: the near miss of the far wall has the wrong sign",
            "            clearance[0] = far.gap - top\n",
            "            clearance[0] = far.gap + top\n",
            _EITHER_WALL,
        ),
        (
            "exact: cells with a miss of the far wall are sought at the near one",
            "max(-r0, -r1) + slack > far.gap - clearance[0]",
            "max(r0, r1) + slack > far.gap - clearance[0]",
            _WHICH_CELLS,
        ),
        (
            "exact: no cell holds a miss of the far wall",
            "possible = possible or max(-r0, -r1) + slack > far.gap - clearance[0]",
            "pass",
            _WHICH_CELLS,
        ),
    ),
    *of(
        "nlds_vines/kernels/watch/touch.py",
        (
            "touch: steps past near misses are ten times longer",
            "        if x + safe >= end:\n            return best\n        x += safe\n",
            "        safe *= 10.0\n        if x + safe >= end:\n            return best\n        x += safe\n",
            _T_EXACT + "test_the_closest_of_many_misses",
        ),
        (
            "touch: steps up to a maximum are five times longer",
            "        safe = 2.0 * slope / (root - curve) if curve < 0.0 else (curve + root) / jerk\n",
            "        safe = 10.0 * slope / (root - curve) if curve < 0.0 else 5.0 * (curve + root) / jerk\n",
            _T_EXACT + "test_the_closest_of_many_misses",
        ),
    ),
    *of(
        "nlds_vines/kernels/impact/approach.py",
        (
            "impact: the drift is no part of the size",
            "abs(drag) + 2.0 * abs(drift) + abs(spring)",
            "abs(drag) + abs(spring)",
            _T_IMPACT + "test_the_size_of_an_impact_bounds_all_other_acceleration_during_it",
        ),
        (
            "impact: the drag has no part in the small numbers' sum",
            "size = abs(force) + abs(drag) + 2.0 * abs(drift)",
            "size = abs(force) + 2.0 * abs(drift)",
            _T_IMPACT + "test_the_size_of_an_impact_bounds_all_other_acceleration_during_it",
        ),
        (
            "impact: the first guess forgets the drag",
            "w[PRODUCTS + AT_FORCE], w[PRODUCTS + AT_DRAG] = approach.force, approach.drag",
            "w[PRODUCTS + AT_FORCE], w[PRODUCTS + AT_DRAG] = approach.force, 0.0",
            _T_IMPACT + "test_the_first_guess_errs_by_the_second_order_or_higher",
        ),
        (
            "impact: the first guess forgets the drift",
            "w[PRODUCTS + AT_DRIFT], w[PRODUCTS + AT_SPRING] = approach.drift, approach.spring",
            "w[PRODUCTS + AT_DRIFT], w[PRODUCTS + AT_SPRING] = 0.0, approach.spring",
            _T_IMPACT + "test_the_first_guess_errs_by_the_second_order_or_higher",
        ),
    ),
    *of(
        "nlds_vines/kernels/impact/arc_table.py",
        (
            "impact: whatever the tolerance, the fewest nodes",
            "[LEVELS + LEVEL * level + error] * scale <= arc.tolerance",
            "[LEVELS + LEVEL * level + error] * scale < math.inf",
            _T_IMPACT + "test_the_nodes_are_the_fewest_that_the_tolerance_allows",
        ),
    ),
    *of(
        "nlds_vines/kernels/impact/impact.py",
        (
            "impact: what the nodes miss of the dashpots is left out",
            "        b = b + term * four_at(w, at + k)\n",
            "",
            _T_IMPACT + "test_what_the_nodes_miss_of_the_dashpots_is_added",
        ),
        (
            "impact: half the contact's own force is a small share",
            "LARGEST = 0.15 ",
            "LARGEST = 0.5 ",
            _T_IMPACT + "test_only_a_small_share_of_other_forces_is_taken_for_a_short_impact",
        ),
        (
            "impact: a hundredth of the contact's own force is a large share",
            "LARGEST = 0.15 ",
            "LARGEST = 0.01 ",
            _T_IMPACT + "test_only_a_small_share_of_other_forces_is_taken_for_a_short_impact",
        ),
        (
            "impact: a long impact is short",
            "LONGEST = 0.25 ",
            "LONGEST = 0.5 ",
            _T_IMPACT
            + "test_only_what_is_short_beside_all_other_motion_is_taken_for_a_short_impact",
        ),
        (
            "impact: the depth is looked for on the whole arc",
            "solve_arc(side, int(HALF), int(HALF_ERROR), approach)",
            "solve_arc(side, int(WHOLE), int(HALF_ERROR), approach)",
            _T_IMPACT + "test_depth_wherever_a_short_impact_is_accepted",
        ),
    ),
    *of(
        "nlds_vines/kernels/events/contact_step.py",
        (
            "contact: what is back at the end of a step was not out",
            "    if k[NEW] > 0.0 and k[OLD + 1] < 0.0 and k[NEW + 1] > 0.0:",
            "    if k[NEW] > 0.0 and k[OLD + 1] < 0.0 and k[NEW + 1] > 1e9:",
            _T_CONTACT + "test_a_damper_that_is_out_and_back_by_the_end_of_a_step_is_released",
        ),
        (
            "contact: the deepest point without its parabola",
            "        found = z + more",
            "        found = z",
            _T_CONTACT + "test_depth_where_a_contact_comes_to_rest",
        ),
        (
            "contact: a section does not end a step",
            "return Step(phase, False, step_to_stop(side, step, left)), True",
            "step_to_stop(side, step, left)\n        return step, False",
            _T_CONTACT + "test_depth_where_a_section_cuts_the_contact_behind_it",
        ),
        (
            "contact: the deepest point by one guess",
            "MOST_TURNS = 60",
            "MOST_TURNS = 1",
            _T_CONTACT + "test_depth_where_a_contact_comes_to_rest",
        ),
    ),
    *of(
        "nlds_vines/kernels/watch/peaks.py",
        (
            "peaks: a factor that comes near zero has no root",
            "min(abs(f), abs(g)) > 0.125 * bend",
            "min(abs(f), abs(g)) > 0.0125 * bend",
            _T_EXACT + "test_no_root_is_proven_only_where_there_is_none",
        ),
        (
            "peaks: a factor that changes by a tenth of its bend is monotone",
            "or abs(g - f) > bend)",
            "or abs(g - f) > 0.1 * bend)",
            _T_EXACT + "test_no_root_is_proven_only_where_there_is_none",
        ),
    ),
    *of(
        "nlds_vines/kernels/motion/bounds.py",
        (
            "exact: the bound of the energy scale's growth forgets the forcing",
            "    first = grid.rate * scale + grid.push\n",
            "    first = grid.rate * scale\n",
            _PARTS,
        ),
        (
            "exact: the bound of its second derivative forgets the forcing",
            "    second = grid.rate * first + push\n",
            "    second = grid.rate * first\n",
            _PARTS,
        ),
        (
            "flight: the bend forgets the damper's speed",
            "    squares += on_v2 * on_v2 / damper.m2\n",
            "",
            _BEND,
        ),
        (
            "flight: the bend forgets the damper's spring",
            "    squares += damper.k2 * damper.inv_mu * damper.inv_mu\n",
            "",
            _BEND,
        ),
        (
            "flight: the bend forgets the structure's speed",
            "    squares += on_v1 * on_v1 / ps.m1\n",
            "",
            _BEND,
        ),
        (
            "flight: the rate forgets the spring's pull on the structure",
            "    on_v1 += drag1 + pull1 + across",
            "    on_v1 += drag1 + across",
            _RATE,
        ),
        (
            "flight: the rate forgets the spring's pull on the damper",
            "    on_v2 = pull2 + drag2 + across",
            "    on_v2 = drag2 + across",
            _RATE,
        ),
        (
            "flight: the rate of the spring forgets the damper",
            "max(pull1 + pull2, ps.omega)",
            "max(pull1, ps.omega)",
            _RATE,
        ),
        (
            "flight: the rate of the spring forgets the structure",
            "max(pull1 + pull2, ps.omega)",
            "max(pull2, ps.omega)",
            _RATE,
        ),
    ),
)
