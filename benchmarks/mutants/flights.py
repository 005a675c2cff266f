"""Mutants: scene, flight, touch, peaks, exact."""

from __future__ import annotations

from benchmarks.mutants.mutant import of

_T_ORDER = "tests/reference/test_order.py::"
_T_EXACT_FACTS = "tests/reference/test_exact_facts.py::"
_T_VARIATIONS = "tests/kernels/test_variations.py::"
_T_TOUCH = "tests/kernels/plain_touch.py::"
_PLAIN_ORBIT = "tests/kernels/plain_orbit.py::"
_PLAIN_BOUNDS = "tests/kernels/plain_bounds.py::"
_T_ENERGIES = "tests/reference/test_energies.py::"
_T_CUBICS = "tests/kernels/plain_cubics.py::"
_T_EXACT = "tests/kernels/plain_exact.py::"
_T_FLIGHT = "tests/kernels/plain_flight.py::"
_T_PEAKS = "tests/kernels/test_peaks.py::"
_T_PHASE = (
    "tests/bifurcation/test_phase_of_starts.py::"
    "test_a_start_on_an_orbit_comes_to_the_orbits_next_section"
)
_PLAIN_METHODS = "tests/property/plain_methods.py::"
_PLAIN_PEAKS = "tests/kernels/plain_peaks.py::"

MUTANTS = (
    *of(
        "nlds_vines/kernels/scene/scene.py",
        (
            "scene: the force of a wall is left out of the damper's share",
            "return alone - pull * damper.inv_m1, without_shaking",
            "return alone - (pull - contact) * damper.inv_m1, without_shaking",
            _T_ORDER + "test_free_hertz_impact",
        ),
        (
            "scene: the dashpot of the structure is left out",
            "ps.force * drive - ps.stiffness * x1 - ps.damping * v1",
            "ps.force * drive - ps.stiffness * x1",
            _T_EXACT_FACTS + "test_steady_state",
        ),
        (
            "scene: the damping of the spring's dashpot works on the structure alone",
            "pull = damper.k2 * r + damper.c2 * s + contact\n    return alone - pull * damper.inv_m1",
            "pull = damper.k2 * r + contact\n    return alone - (pull + damper.c2 * s) * damper.inv_m1",
            _T_ORDER + "test_short_impact_converges_geometrically_to_the_stepped_contact",
        ),
        (
            "scene: the energy scale leaves out the damper's motion",
            "energy += damper.k2 * r * r + damper.m2 * v2 * v2",
            "energy += damper.k2 * r * r",
            _PLAIN_BOUNDS + "test_the_energy_scale_is_that_of_both_bodies",
        ),
        (
            "scene: the reduced mass is the damper's",
            "inv_mu = inv_m1 + 1.0 / cell.m2",
            "inv_mu = 1.0 / cell.m2",
            _T_ORDER + "test_free_hertz_impact",
        ),
        (
            "scene: walls that overlap are allowed",
            "fine = fine and cell.near + cell.far >= 0.0",
            "fine = fine and finite(cell.near)",
            _PLAIN_BOUNDS + "test_numbers_that_are_allowed",
        ),
        (
            "scene: a negative force is allowed to the exact method",
            "fine = fine and finite(cell.P) and (parts.rk4 is not None or cell.P >= 0.0)",
            "fine = fine and finite(cell.P)",
            _PLAIN_BOUNDS + "test_numbers_that_are_allowed",
        ),
        (
            "scene: a negative dashpot is allowed",
            "0.0 <= cell.k2 < math.inf and 0.0 <= cell.c2 < math.inf",
            "0.0 <= cell.k2 < math.inf and cell.c2 < math.inf",
            _PLAIN_BOUNDS + "test_numbers_that_are_allowed",
        ),
    ),
    *of(
        "nlds_vines/kernels/motion/flight.py",
        (
            "flight: the rest of a period has the phases of a whole one",
            "    return begun.phase + begun.share * share",
            "    return share",
            _T_PHASE + "[sticking]",
        ),
        (
            "flight: the cells of the rest of a period turn as those of a whole one",
            "return begun.share",
            "return 1.0",
            _T_PHASE + "[restitution]",
        ),
        (
            "flight: the forced response without its sine",
            "w[at_cell + c] = response[16 + c] * cosine + response[20 + c] * sine",
            "w[at_cell + c] = response[16 + c] * cosine",
            _T_EXACT_FACTS + "test_steady_state",
        ),
        (
            "flight: the transition lacks what the spring's rate gives to x1",
            "(w[0] * x1 + w[4] * v1) + (w[8] * r + w[12] * s) + w[f],",
            "(w[0] * x1 + w[4] * v1) + (w[8] * r) + w[f],",
            _T_EXACT_FACTS + "test_defective_and_degenerate_flights",
        ),
        (
            "flight: a share of a period takes the forcing of the first",
            "first = 0 if i < 4 else (i - 4) * share",
            "first = 0",
            _T_EXACT_FACTS + "test_sections_within_a_period",
        ),
        (
            "flight: variations propagate without the last piece of a cell",
            "x = time / grid.h - cells",
            "x = 0.0 * time",
            _T_VARIATIONS + "test_determinant_is_known_beforehand[two walls-exact]",
        ),
        (
            "flight: the Taylor polynomials have order 8",
            "ORDER = 14",
            "ORDER = 8",
            _T_EXACT_FACTS + "test_defective_and_degenerate_flights",
        ),
        (
            "flight: the free responses of a share of a period are forced",
            "silent[CELLS:] = 0.0",
            "silent[CELLS:CELLS] = 0.0",
            _T_EXACT_FACTS + "test_sections_within_a_period",
        ),
        (
            "flight: a start inside a cell takes the state of its start for r",
            "    y = low + ((pair(w, 8, x) + pair(w, 10, x) * x2) + last * x4) * (x4 * x4)\n",
            "    y = pair(w, 0, x) + 0.0 * (low + last)\n",
            _T_EXACT_FACTS + "test_impact_free_orbit[9.0]",
        ),
    ),
    *of(
        "nlds_vines/kernels/watch/touch.py",
        (
            "touch: the safe distance forgets the bend",
            "square = slope * slope + 2.0 * bend * clearance",
            "square = slope * slope",
            _T_TOUCH + "test_an_approach_that_speeds_up",
        ),
        (
            "touch: a start on the wall that is pressed in is no touch",
            "if slope > 0.0 or (slope == 0.0 and curve > 0.0):",
            "if slope > 0.0:",
            _T_TOUCH + "test_touch[on the wall, pressed in]",
        ),
        (
            "touch: the third derivative of a polynomial counts once",
            "third += (k - 2.0) * part",
            "third += (k - 2.0) * part / k",
            _PLAIN_BOUNDS + "test_bounds_from_the_polynomial_hold",
        ),
    ),
    *of(
        "nlds_vines/kernels/watch/peaks.py",
        (
            "peaks: a step of a contact holds no more than its ends",
            "i, part = COEF + 4 * n, n * (n - 1.0) * sag",
            "i, part = COEF + 4 * n, 0.0 * sag",
            _PLAIN_METHODS + "test_the_largest_energies_are_those_of_many_samples",
        ),
        (
            "peaks: a factor of the damper's energy takes it for the structure",
            "x - w[i + 2], v - w[i + 3], a - ds",
            "x - w[i + 2], v - w[i + 3], a",
            _T_ENERGIES + "test_the_peak_of_a_linear_transient",
        ),
        (
            "peaks: roots of a factor are proven absent by its values alone",
            "return alike(f, g) and (min(abs(f), abs(g)) > 0.125 * bend or abs(g - f) > bend)",
            "return alike(f, g)",
            _T_PEAKS + "test_a_double_root_is_not_proven_absent",
        ),
        (
            "peaks: a rise between the ends of a cell is not expected",
            "highest(e0, e1, p0, p1, fourth) > record",
            "max(e0, e1) > record",
            _PLAIN_PEAKS + "test_what_rises_between_the_ends_of_a_cell_is_suspected",
        ),
        (
            "peaks: powers are taken for those of a second",
            "    possible = highest(before[0], after[0], h * before[2], h * after[2], fourth) > energy[0]\n",
            "    possible = highest(before[0], after[0], 0.1 * h * before[2], 0.1 * h * after[2], fourth) > energy[0]\n",
            _PLAIN_PEAKS + "test_powers_count_with_the_time_that_they_have",
        ),
        (
            "peaks: what does not only fall is taken for what only rises",
            "        and not only_rises(e0, e1, p0, p1, fourth)\n",
            "        and not (e0 < e1)\n",
            _PLAIN_PEAKS + "test_the_largest_energies_of_flights_from_touch_to_touch",
        ),
        (
            "peaks: the damper's energy is not searched",
            "if bodies & (1 << which // 2):",
            "if bodies & (1 << which):",
            _PLAIN_PEAKS + "test_the_largest_energies_of_flights_from_touch_to_touch",
        ),
        (
            "peaks: a piece that holds a single root is passed over",
            "note_at(noter, root(w, x, x + width, f, g))",
            "note_at(noter, x + width)",
            _PLAIN_PEAKS + "test_the_largest_of_a_piece_are_those_of_its_samples",
        ),
        (
            "peaks: a factor's polynomial forgets the spring",
            "mass * a + spring * x",
            "mass * a",
            _PLAIN_PEAKS + "test_the_polynomial_of_a_factor_is_the_factor",
        ),
        (
            "peaks: the bound from a factor's polynomial counts its first terms alone",
            "bend += n * (n - 1.0) * abs(w[FACTOR + n])",
            "bend += abs(w[FACTOR + n]) if n == 2 else 0.0",
            _PLAIN_PEAKS + "test_the_polynomial_of_a_factor_is_the_factor",
        ),
        (
            "peaks: half the bound of a damper's rise is expected",
            "fourth = damper_bound(grid, bounds.scale, before[1]) * shorter",
            "fourth = 0.5 * damper_bound(grid, bounds.scale, before[1]) * shorter",
            _PLAIN_PEAKS + "test_the_error_of_the_cubic_counts_for_each_body",
        ),
        (
            "peaks: a damper is bounded as if the structure gave it nothing",
            "    u0 = math.sqrt(2.0 * e2) + (pull * scale + shaken) * grid.h\n",
            "    u0 = math.sqrt(2.0 * e2)\n",
            _PLAIN_BOUNDS + "test_the_bound_of_the_damper_is_reached_where_it_is_alone",
        ),
    ),
    *of(
        "nlds_vines/kernels/events/exact.py",
        (
            "exact: a cell is clear of the near wall if its ends are",
            "proven = max(r0, r1) + slack < near.gap",
            "proven = max(r0, r1) < near.gap",
            _PLAIN_BOUNDS + "test_a_cell_is_clear_where_its_ends_and_the_bend_say_so",
        ),
        (
            "exact: a cell is clear of the far wall if its ends are",
            "proven = proven and max(-r0, -r1) + slack < far.gap",
            "proven = proven and max(-r0, -r1) < far.gap",
            _PLAIN_BOUNDS + "test_a_cell_is_clear_where_its_ends_and_the_bend_say_so",
        ),
        (
            "exact: a flight from inside a cell is taken for one from its start",
            "            if x > 0.0:\n                filled = fill",
            "            if x > 2.0:\n                filled = fill",
            _PLAIN_ORBIT + "test_a_flight_may_begin_anywhere_in_a_cell",
        ),
        (
            "exact: a touch that is lost is passed over",
            "if place == LOST:\n        event = ASTRAY",
            "if place == LOST:\n        event = SECTION",
            _PLAIN_BOUNDS + "test_a_touch_that_cannot_be_told_is_not_passed_over",
        ),
        (
            "exact: a passage of the limit within a cell is not looked for",
            "x > 0.0 or event != SECTION or max(r, y[2]) + slack >= limit_log[LIMIT]",
            "x > 0.0 or event != SECTION or max(r, y[2]) >= limit_log[LIMIT]",
            _PLAIN_METHODS + "test_an_excursion_beyond_a_limit_may_be_short",
        ),
        (
            "exact: energies at a release are not noted",
            "        energy[0], energy[1] = max(energy[0], before[0]), max(energy[1], before[1])\n",
            "",
            _PLAIN_PEAKS + "test_the_largest_energies_of_flights_from_touch_to_touch",
        ),
        (
            "exact: energies at the ends of cells are not noted",
            "                energy[0], energy[1] = max(energy[0], after[0]), max(energy[1], after[1])\n",
            "",
            _PLAIN_METHODS + "test_both_methods_note_the_same[none]",
        ),
        (
            "exact: times of the limit are those of the cell's start",
            "note_limit(grid, limit_log, j + x, place",
            "note_limit(grid, limit_log, j, place",
            _PLAIN_METHODS + "test_a_fast_damper_strikes_several_times_in_a_cell",
        ),
    ),
    *of(
        "nlds_vines/kernels/motion/flight.py",
        (
            "flight: a term of the phase inside a cell is forgotten",
            "z2 * (1.0 / 1307674368000.0)",
            "z2 * 0.0",
            _T_FLIGHT + "test_the_phase_inside_a_cell",
        ),
    ),
    *of(
        "nlds_vines/kernels/numerics/roots.py",
        (
            "cubics: the error of a value is left out",
            "    return top + VALUE_ERROR * fourth",
            "    return top",
            _T_CUBICS + "test_the_highest_value_is_bounded_and_reached",
        ),
        (
            "cubics: the error of a slope is that of a value",
            "> SLOPE_ERROR * fourth",
            "> VALUE_ERROR * fourth",
            _T_CUBICS + "test_what_only_rises_is_told_just_so",
        ),
        (
            "cubics: the slope in the middle is not looked at",
            "min(min(g0, g1), 3.0 * (f1 - f0) - g0 - g1)",
            "min(g0, g1)",
            _T_CUBICS + "test_what_only_rises_is_told_just_so",
        ),
        (
            "cubics: the middle coefficients are left out",
            "max(max(f0, f1), max(f0 + g0 * (1.0 / 3.0), f1 - g1 * (1.0 / 3.0)))",
            "max(f0, f1)",
            _T_CUBICS + "test_the_highest_value_is_bounded_and_reached",
        ),
    ),
    *of(
        "nlds_vines/kernels/watch/touch.py",
        (
            "touch: a rise through the level is not certain",
            "            return CROSSED if f1 >= level else CLEAR\n",
            "            return CLEAR\n",
            _T_EXACT + "test_what_the_ends_of_a_piece_tell_is_so",
        ),
        (
            "touch: what is a thousandth below the level is on it",
            "        if level - f0 > tolerance_of(w, level):\n",
            "        if level - f0 > 1e-3 * level:\n",
            _T_EXACT + "test_a_certain_touch_is_found_to_round_off",
        ),
        (
            "touch: Newton's last step comes too early",
            "        if bend * change * change <= ROUND_OFF * slope:\n",
            "        if bend * change * change <= 1e-6 * slope:\n",
            _T_EXACT + "test_a_certain_touch_is_found_to_round_off",
        ),
        (
            "touch: Newton's steps may leave the piece",
            "        x = guarded(x, low, high)\n        y = at(",
            "        y = at(",
            _T_EXACT + "test_steps_towards_a_touch_stay_in_the_piece",
        ),
    ),
    *of(
        "nlds_vines/kernels/motion/bounds.py",
        (
            "flight: the rate forgets the dashpot's share across",
            "on_v1 += drag1 + pull1 + across",
            "on_v1 += drag1 + pull1",
            _PLAIN_BOUNDS + "test_the_rate_is_the_largest_row_sum",
        ),
        (
            "flight: the damper's displacement is bounded as if its structure stood",
            "absolute = 1.0 + soft",
            "absolute = 1.0",
            _PLAIN_BOUNDS + "test_the_dampers_energy_is_bounded_by_the_scale",
        ),
        (
            "flight: a period has a quarter of the cells it needs",
            "need = period * rate_of(ps, joined(damper)) / REACH",
            "need = 0.25 * period * rate_of(ps, joined(damper)) / REACH",
            _PLAIN_BOUNDS + "test_a_cell_is_short_beside_the_rate",
        ),
        (
            "flight: too many cells are no reason to refuse",
            "return -1",
            "return MOST_CELLS",
            _PLAIN_BOUNDS + "test_more_cells_than_memory_are_refused",
        ),
        (
            "exact: the bound of the third derivative forgets the forcing",
            "(grid.bend * first + ps.omega * ps.force) * h2 * grid.h",
            "(grid.bend * first) * h2 * grid.h",
            _PLAIN_BOUNDS + "test_bounds_of_what_only_the_force_moves_are_reached",
        ),
        (
            "exact: the bound of the second derivative forgets the forcing",
            "(grid.bend * scale + greatest_push(ps.load, ps.force)) * h2",
            "(grid.bend * scale) * h2",
            _PLAIN_BOUNDS + "test_bounds_of_what_only_the_force_moves_are_reached",
        ),
        (
            "exact: the bound of an energy's fourth derivative forgets the square",
            "(scale * fourth + 4.0 * first * third + 3.0 * second * second) * h2 * h2",
            "(scale * fourth + 4.0 * first * third) * h2 * h2",
            _PLAIN_BOUNDS + "test_bounds_of_what_only_the_force_moves_are_reached",
        ),
        (
            "exact: the bound of the fourth derivative forgets the forcing",
            "(grid.bend * second + ps.omega * ps.omega * ps.force) * h2 * h2",
            "(grid.bend * second) * h2 * h2",
            _PLAIN_BOUNDS + "test_bounds_of_what_only_the_force_moves_are_reached",
        ),
        (
            "flight: the rate of a damper forgets its dashpot",
            "    own = math.sqrt(damper.k2 / damper.m2) + damper.c2 / damper.m2\n",
            "    own = math.sqrt(damper.k2 / damper.m2)\n",
            _PLAIN_BOUNDS + "test_the_bound_of_the_damper_is_reached_where_it_is_alone",
        ),
    ),
)
