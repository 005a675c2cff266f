"""Mutants: what is noted, orbit, cells, lanes, variations, growth."""

from __future__ import annotations

from benchmarks.mutants.mutant import of

_PLAIN_INSIDE = "tests/kernels/plain_inside.py::"
_PLAIN_METHODS = "tests/property/plain_methods.py::"
_T_ENERGIES = "tests/reference/test_energies.py::"
_T_TOUCH = "tests/kernels/plain_touch.py::"
_T_EXACT_FACTS = "tests/reference/test_exact_facts.py::"
_PLAIN_ORBIT = "tests/kernels/plain_orbit.py::"
_T_SIMULATION = "tests/orbits/test_simulation.py::"
_T_VARIATIONS = "tests/kernels/test_variations.py::"
_PLAIN_SWEEPS = "tests/bifurcation/plain_sweeps.py::"
_T_GROWTH = "tests/kernels/plain_growth.py::"

MUTANTS = (
    *of(
        "nlds_vines/kernels/watch/observe.py",
        (
            "observe: an impact's gain is counted from zero",
            "data[i + GAIN1], data[i + GAIN2] = -e1, -e2",
            "data[i + GAIN1], data[i + GAIN2] = 0.0 * e1, -e2",
            _T_ENERGIES + "test_gains_are_differences_of_the_energies",
        ),
        (
            "observe: the first violation is the last",
            "    if limit_log[NUMBER] == 0.0:\n        limit_log[FIRST_VIOLATION] = time",
            "    limit_log[FIRST_VIOLATION] = time",
            _T_TOUCH + "test_passages_are_counted_with_the_first_and_the_deepest",
        ),
        (
            "observe: the damper's energy is that of its stretch",
            "v2, w = v1 - s, x1 - r",
            "v2, w = v1 - s, -r",
            _T_ENERGIES + "test_gains_are_differences_of_the_energies",
        ),
        (
            "observe: the section leaves out the rest offset",
            "x1 - r + damper.rest, v1 - s",
            "x1 - r, v1 - s",
            _T_EXACT_FACTS + "test_impact_free_orbit",
        ),
    ),
    *of(
        "nlds_vines/kernels/laws/hertz.py",
        (
            "elastic contact: a short impact goes on where a section cut it, as if it had not begun",
            "    k[AHEAD + 1] = before + left\n",
            "",
            _PLAIN_INSIDE + "test_samples_inside_impacts_are_states_of_the_orbit[64]",
        ),
        (
            "elastic contact: a section inside a short impact ends it",
            "    stops = remains > left\n",
            "    stops = remains > left + 1.0\n",
            _PLAIN_INSIDE + "test_samples_inside_impacts_are_states_of_the_orbit[64]",
        ),
    ),
    *of(
        "nlds_vines/kernels/scene/drive.py",
        (
            "drive: the forcing is not mirrored for a far wall",
            "return (sign * phase[0], sign * phase[1])",
            "return (phase[0], phase[1])",
            "tests/reference/test_published.py::test_the_named_system_follows_the_reference",
        ),
    ),
    *of(
        "nlds_vines/kernels/orbit/orbit.py",
        (
            "orbit: a start beyond the near wall is in flight",
            "state[5] = TOUCH_NEAR if",
            "state[5] = FLYING if",
            _PLAIN_ORBIT + "test_a_state_beyond_a_wall_is_inside_a_contact",
        ),
        (
            "orbit: a start beyond the far wall is in flight",
            "state[5] = TOUCH_FAR if",
            "state[5] = FLYING if",
            _PLAIN_ORBIT + "test_a_state_beyond_a_wall_is_inside_a_contact",
        ),
        (
            "orbit: the slowest impact is the fastest",
            "slowest[0] = min(slowest[0], abs(s))",
            "slowest[0] = max(slowest[0], abs(s))",
            _PLAIN_ORBIT + "test_the_slowest_of_all_impacts",
        ),
        (
            "orbit: times count from the end of the transient",
            "began = began_at(grid, span.first + p)",
            "began = began_at(grid, p)",
            _T_SIMULATION + "test_impact_times_count_from_the_start_of_the_transient",
        ),
        (
            "orbit: impacts at the far wall are counted at the near one",
            "by_period[p, mode - TOUCH_NEAR] += 1",
            "by_period[p, 0] += 1",
            _T_VARIATIONS + "test_monodromy_is_the_derivative_of_the_flow[two walls-exact]",
        ),
        (
            "orbit: a contact that spends its steps has ended well",
            "                if event == EXHAUSTED:\n                    return STEP_BUDGET\n",
            "                if event == EXHAUSTED:\n                    return OK\n",
            _PLAIN_ORBIT + "test_a_contact_that_spends_its_steps_is_not_gone_on_with",
        ),
        (
            "orbit: touches without end are no reason to stop",
            "                    if touches > MOST_TOUCHES:\n                        return STEP_BUDGET\n",
            "",
            _PLAIN_ORBIT + "test_touches_without_end_are_stopped",
        ),
        (
            "orbit: any finite state is bounded",
            "HUGE = 1.0e150",
            "HUGE = 1.0e400",
            _PLAIN_ORBIT + "test_states_are_bounded",
        ),
        (
            "orbit: a linear scene with energies skips the stops of a period",
            "first, stop = flight.grid.n * i // stops, flight.grid.n * (i + 1) // stops",
            "first, stop = 0, flight.grid.n",
            _T_EXACT_FACTS + "test_sections_within_a_period",
        ),
    ),
    *of(
        "nlds_vines/kernels/cells/cells.py",
        (
            "cells: an energy beyond all numbers is a result",
            "    if status == OK and (overflowed(buffers.energy) or overflowed(buffers.peak)):\n        return DIVERGED\n",
            "",
            _PLAIN_ORBIT + "test_an_energy_beyond_all_numbers_is_no_result",
        ),
        (
            "cells: the largest energies begin with zero",
            "        note_energy(ps, damper, energy, state[0], state[1], state[2], state[3])",
            "        energy[0] = 0.0",
            _T_ENERGIES + "test_a_start_may_be_the_peak",
        ),
        (
            "cells: the peak forgets the sampled periods",
            "        raise_peak(buffers.energy, peak)\n",
            "",
            _PLAIN_METHODS + "test_both_methods_note_the_same[tmd]",
        ),
        (
            "cells: a start beyond the limit is not counted",
            "    begin_limit_log(limit_log, state)\n",
            "",
            _PLAIN_ORBIT + "test_a_start_beyond_a_limit_is_a_violation_of_the_first_instant",
        ),
        (
            "cells: a limit that is no number is kept",
            "    return not finite(limit)",
            "    return False",
            _PLAIN_ORBIT + "test_a_limit_that_is_no_number_is_refused",
        ),
        (
            "cells: fixed steps may be unstable",
            "STABLE = 2.5",
            "STABLE = 1.0e9",
            _T_SIMULATION + "test_fixed_steps_beyond_their_stability_are_refused",
        ),
        (
            "cells: a grid need not hold the stops",
            "return stops * ((n + stops - 1) // stops)",
            "return n",
            _PLAIN_ORBIT + "test_cells_are_a_multiple_of_the_stops",
        ),
    ),
    *of(
        "nlds_vines/kernels/cells/lanes.py",
        (
            "lanes: a sweep does not carry the rest offset",
            "state[2] += cell.rest - cells[chain, link - 1].rest",
            "state[2] += 0.0",
            _PLAIN_SWEEPS + "test_every_link_begins_where_the_one_before_ended",
        ),
        (
            "lanes: a lane that failed hands on its state",
            "                state[:] = 0.0",
            "                state[:] = state",
            _PLAIN_SWEEPS + "test_after_a_link_that_failed_the_next_begins_at_rest",
        ),
        (
            "lanes: a sweep adds the rest offset after a failure too",
            "if link > 0 and status[chain, link - 1] == OK:",
            "if link > 0:",
            _PLAIN_SWEEPS + "test_after_a_link_that_failed_the_next_begins_at_rest",
        ),
        (
            "lanes: impacts of the last period are left out",
            "for p in range(len(by_period)):",
            "for p in range(len(by_period) - 1):",
            _PLAIN_SWEEPS + "test_impacts_are_counted_by_wall",
        ),
    ),
    *of(
        "nlds_vines/kernels/orbit/variations.py",
        (
            "variations: the divergence forgets the damper's dashpot",
            "return -ps.damping - damper.c2 * damper.inv_mu",
            "return -ps.damping",
            _T_VARIATIONS + "test_the_divergences_of_the_named_systems",
        ),
        (
            "variations: a start inside a contact is in flight",
            "    set_mode(flow.prepared.near, flow.prepared.far, state)",
            "    state[4] = 0.0",
            _T_VARIATIONS
            + "test_monodromy_is_the_derivative_of_the_flow[it begins inside a contact-exact]",
        ),
        (
            "variations: vectors are made orthogonal once",
            "MUCH = 4.0",
            "MUCH = 1e300",
            _T_VARIATIONS + "test_lengths_along_triangular_matrices",
        ),
        (
            "variations: impacts of the period before are counted again",
            "    flow.by_period[:periods] = 0\n",
            "",
            _T_VARIATIONS
            + "test_monodromy_is_the_derivative_of_the_flow[an impact a period-exact]",
        ),
    ),
    *of(
        "nlds_vines/kernels/numerics/matrices.py",
        (
            "linear: elimination without pivots",
            "if abs(matrix[j, i]) > abs(matrix[pivot, i]):",
            "if matrix[pivot, i] == 0.0:",
            _PLAIN_ORBIT + "test_elimination_exchanges_rows_for_a_small_pivot",
        ),
        (
            "linear: the first right side alone is solved for",
            "        for c in range(right.shape[1]):\n            for j in range(i + 1, size):",
            "        for c in range(1):\n            for j in range(i + 1, size):",
            _T_VARIATIONS + "test_elimination[4]",
        ),
    ),
    *of(
        "nlds_vines/kernels/orbit/growth.py",
        (
            "growth: the first twentieth is kept",
            "UNFIT = 0.05",
            "UNFIT = 0.0",
            _T_GROWTH + "test_the_beginning_of_a_sequence_does_not_count",
        ),
        (
            "growth: the interval is that of 95 %",
            "QUANTILE = 2.947",
            "QUANTILE = 2.131",
            _T_GROWTH + "test_the_interval_holds_the_mean_in_as_many_cases_as_it_claims",
        ),
        (
            "growth: the interval counts the batches as if they were known",
            "math.sqrt(spread / (BATCHES - 1) / BATCHES)",
            "math.sqrt(spread / (BATCHES - 1))",
            _T_GROWTH + "test_the_interval_holds_the_mean_in_as_many_cases_as_it_claims",
        ),
        (
            "growth: digits are not relative",
            "max(abs(off) / extent, 1.0e-15)",
            "max(abs(off), 1.0e-15)",
            _T_GROWTH + "test_digits_do_not_depend_on_the_unit",
        ),
    ),
)
