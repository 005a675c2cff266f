"""Mutants: shooting, recurrence, settling, the search for periods, verdicts, elementary functions."""

from __future__ import annotations

from benchmarks.mutants.mutant import of

_PLAIN_VERDICT = "tests/kernels/plain_verdict.py::"
_T_VERDICT = "tests/kernels/test_verdict.py::"
_T_CLASSIFICATION = "tests/orbits/test_classification.py::"
_T_GROWTH = "tests/kernels/plain_growth.py::"
_T_VARIATIONS = "tests/kernels/test_variations.py::"
_T_ELEMENTARY = "tests/kernels/test_elementary.py::"
_T_EIGENVALUES = "tests/kernels/plain_eigenvalues.py::"

MUTANTS = (
    *of(
        "nlds_vines/kernels/cells/course.py",
        (
            "course: variations are projected as seldom where volumes shrink fast",
            "MOST_SHRUNK = 6.0",
            "MOST_SHRUNK = 60.0",
            _T_VARIATIONS
            + "test_growth_is_the_same_however_often_variations_are_projected[ssul-set6-changes2-1]",
        ),
        (
            "course: batches are as short as the means that they are made of",
            "SEVERAL = 8",
            "SEVERAL = 0.5",
            _T_VERDICT + "test_the_regimes_of_set_6[7.45-3T,2]",
        ),
    ),
    *of(
        "nlds_vines/kernels/orbit/shooting.py",
        (
            "shooting: every number of periods is minimal",
            "        if n % d == 0 and distance(space, points[d - 1], y) <= SAME_POINT * span:\n            return False",
            "        if n % d == 0 and distance(space, points[d - 1], y) < 0.0:\n            return False",
            _PLAIN_VERDICT
            + "test_only_the_least_number_of_periods_is_minimal[ssul-set6-6.28-1-counts0]",
        ),
        (
            "shooting: points that differ by a thousandth are one",
            "SAME_POINT = 1.0e-8",
            "SAME_POINT = 1.0e-3",
            _PLAIN_VERDICT + "test_a_nearly_closed_orbit_is_minimal",
        ),
        (
            "shooting: impacts of an orbit are those of its last period",
            "            counts[wall] += flow.by_period[0, wall]",
            "            counts[wall] = flow.by_period[0, wall]",
            _PLAIN_VERDICT
            + "test_only_the_least_number_of_periods_is_minimal[ssul-set6-7.45-3-counts2]",
        ),
        (
            "shooting: Newton's correction is halved",
            "            y[i] += step[i]",
            "            y[i] += 0.5 * step[i]",
            _PLAIN_VERDICT + "test_newtons_method_goes_on_until_rounding_stops_it",
        ),
        (
            "shooting: the matrix of an orbit is transposed",
            "matrix[row, column] = tangent[4 * column + row]",
            "matrix[column, row] = tangent[4 * column + row]",
            _T_VARIATIONS + "test_multipliers_of_the_structure_alone",
        ),
    ),
    *of(
        "nlds_vines/kernels/orbit/recurrence.py",
        (
            "recurrence: impacts of a cycle lack its last period",
            "return round(count(by_period, wall, periods - cycles * n, periods) / cycles)",
            "return round(count(by_period, wall, periods - cycles * n, periods - 1) / cycles)",
            _PLAIN_VERDICT + "test_impacts_are_counted_over_whole_cycles",
        ),
        (
            "recurrence: an impact on the instant of a section is counted amiss",
            "cycles = max(1, periods // (2 * n))",
            "cycles = 1",
            _PLAIN_VERDICT + "test_impacts_are_counted_over_whole_cycles",
        ),
        (
            "recurrence: a period need fit once",
            "REPEATS = 3",
            "REPEATS = 1",
            _T_GROWTH + "test_no_period_is_found_where_there_is_none",
        ),
        (
            "recurrence: one component decides",
            "for c in range(section.shape[1]):",
            "for c in range(1):",
            _T_GROWTH + "test_a_period_is_that_of_all_components",
        ),
    ),
    *of(
        "nlds_vines/kernels/cells/settling.py",
        (
            "settling: multipliers near one are not stable",
            "MARGIN = 1.0e-6",
            "MARGIN = 1.0e-2",
            _PLAIN_VERDICT
            + "test_a_weakly_damped_structure_is_periodic_as_long_as_its_multiplier_says_so",
        ),
        (
            "settling: multipliers are stable up to one",
            "MARGIN = 1.0e-6",
            "MARGIN = 1.0e-14",
            _PLAIN_VERDICT
            + "test_a_weakly_damped_structure_is_periodic_as_long_as_its_multiplier_says_so",
        ),
        (
            "settling: every orbit attracts",
            "        if not returns_as_predicted(flow.space, tangent, y, now, state, span):\n            return False",
            "        if not returns_as_predicted(flow.space, tangent, y, now, state, span):\n            return True",
            _PLAIN_VERDICT + "test_an_orbit_that_goes_elsewhere_is_not_attracted",
        ),
        (
            "settling: whatever returns is predicted",
            "PREDICTION_ERROR = 0.25",
            "PREDICTION_ERROR = 1.0e9",
            _PLAIN_VERDICT + "test_an_orbit_that_goes_elsewhere_is_not_attracted",
        ),
        (
            "settling: returns are compared with the orbit's point alone",
            "image[i] += tangent[4 * c + i] * (x[c] - y[c])",
            "image[i] += 0.0 * (x[c] - y[c])",
            _PLAIN_VERDICT + "test_an_orbit_that_is_drawn_in_slowly_is_attracted",
        ),
        (
            "settling: a transient is told chaotic without a look at its exponent",
            "    if mean - width > 0.0:",
            "    if periods > 0:",
            _PLAIN_VERDICT + "test_a_long_transient_is_chaotic_only_with_an_exponent_above_zero",
        ),
    ),
    *of(
        "nlds_vines/kernels/numerics/matrices.py",
        (
            "eigenvalues: a saddle is told by multipliers below one",
            "found[i, RE] > 1.0",
            "found[i, RE] < 1.0",
            _PLAIN_VERDICT + "test_a_saddle_has_one_multiplier_beyond_one",
        ),
    ),
    *of(
        "nlds_vines/kernels/cells/period_search.py",
        (
            "period search: the counts of an orbit's walls are exchanged",
            "evidence[ev.NEAR_IMPACTS], evidence[ev.FAR_IMPACTS] = counts[0], counts[1]",
            "evidence[ev.NEAR_IMPACTS], evidence[ev.FAR_IMPACTS] = counts[1], counts[0]",
            _PLAIN_VERDICT + "test_impacts_of_a_verdict_are_told_by_wall",
        ),
    ),
    *of(
        "nlds_vines/kernels/cells/verdict.py",
        (
            "verdict: an exponent above zero is chaos whatever the averages",
            "return above and evidence[ev.DIGITS] < SMOOTH_DIGITS",
            "return above",
            _T_VERDICT + "test_smooth_averages_are_no_chaos",
        ),
        (
            "verdict: an exponent is chaos whatever its width",
            "above = evidence[ev.LYAPUNOV] - evidence[ev.INTERVAL] > 0.0",
            "above = evidence[ev.LYAPUNOV] > 0.0",
            _T_VERDICT + "test_chaos_needs_an_interval_above_zero",
        ),
        (
            "verdict: a torus is told by its averages alone",
            "return zero and evidence[ev.DIGITS] >= SMOOTH_DIGITS",
            "return evidence[ev.DIGITS] >= SMOOTH_DIGITS",
            _T_VERDICT + "test_a_torus_needs_an_exponent_of_zero_and_smooth_averages",
        ),
        (
            "verdict: a torus is told by its exponent alone",
            "return zero and evidence[ev.DIGITS] >= SMOOTH_DIGITS",
            "return zero",
            _T_VERDICT + "test_a_torus_needs_an_exponent_of_zero_and_smooth_averages",
        ),
        (
            "verdict: the exponent of a cycle is that of its whole length",
            "largest / (n * period), 0.0",
            "largest / period, 0.0",
            _T_VERDICT + "test_the_regimes_of_set_6[7.8-2T,1]",
        ),
        (
            "verdict: averages of one component decide",
            "        digits = min(digits, digits_of(",
            "        digits = max(0.0, digits_of(",
            _T_VERDICT + "test_averages_of_the_worst_component_decide",
        ),
    ),
    *of(
        "nlds_vines/kernels/numerics/elementary.py",
        (
            "elementary: what an angle loses by rounding is forgotten",
            "d = a + ((b - half * b) - a * z * odd)",
            "d = a - a * z * odd",
            _T_ELEMENTARY + "test_errors_are_below_one_unit_in_the_last_place",
        ),
        (
            "elementary: a term of the exponential is missing",
            "(1.0 / 479001600.0 + r * (1.0 / 6227020800.0)) + r2 * (1.0 / 87178291200.0)",
            "(1.0 / 479001600.0) + r2 * (1.0 / 87178291200.0)",
            _T_ELEMENTARY + "test_errors_are_below_one_unit_in_the_last_place",
        ),
        (
            "elementary: ln 2 has half its digits",
            "k * LN2_HIGH - ((half - (s * (half + tail) + k * LN2_LOW)) - f)",
            "k * LN2_HIGH - ((half - s * (half + tail)) - f)",
            _T_ELEMENTARY + "test_errors_are_below_one_unit_in_the_last_place",
        ),
    ),
    *of(
        "nlds_vines/kernels/numerics/matrices.py",
        (
            "eigenvalues: multipliers come in any order",
            "    sort_by_modulus(found)\n    return found",
            "    return found",
            "tests/orbits/test_evidence.py::test_multipliers_come_by_their_moduli",
        ),
        (
            "eigenvalues: the scale of a matrix is not given back",
            "        found[i, RE] *= power_of_two(k)",
            "        found[i, RE] *= 1.0",
            _T_EIGENVALUES + "test_scale_does_not_matter",
        ),
    ),
    *of(
        "nlds_vines/kernels/orbit/growth.py",
        (
            "growth: half as many pieces",
            "BATCHES = 16",
            "BATCHES = 8",
            "tests/kernels/plain_growth.py::test_a_mean_is_as_wide_as_the_means_of_sixteen_pieces_tell",
        ),
        (
            "growth: twice as many pieces",
            "BATCHES = 16",
            "BATCHES = 32",
            "tests/kernels/plain_growth.py::test_a_mean_is_as_wide_as_the_means_of_sixteen_pieces_tell",
        ),
    ),
    *of(
        "nlds_vines/kernels/cells/verdict.py",
        (
            "verdict: variations of a cycle are aligned by one",
            "ALIGNING = 2",
            "ALIGNING = 1",
            "tests/kernels/plain_verdict.py::test_the_fastest_decay_of_a_cycle_is_found_once_its_variations_are_aligned",
        ),
    ),
)
