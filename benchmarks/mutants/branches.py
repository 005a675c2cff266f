"""Mutants: branches, their special points, their ends, and the branches that leave them."""

from __future__ import annotations

from benchmarks.mutants.mutant import of

_T = "tests/continuation/plain_closed_maps.py::"
_NEWTON = _T + "test_newton_closes_an_orbit_in_the_plane_through_the_place"
_TANGENT = _T + "test_a_tangent_has_length_one_and_the_direction_that_is_asked_for"
_STEPS = _T + "test_steps_lengthen_on_a_straight_branch_and_stay_within_the_longest"
_FOLD = _T + "test_a_fold_is_passed_and_located"
_DOUBLING = _T + "test_a_doubling_is_located_from_both_sides"
_TORUS = _T + "test_a_torus_is_located_and_a_neutral_saddle_is_none"
_CROSSING = _T + "test_where_two_branches_cross_there_is_a_branch_point_and_no_fold"
_GRAZING = _T + "test_a_grazing_is_located_with_its_labels_and_its_wall"
_NARROWED = _T + "test_a_sign_change_is_narrowed_down_to_round_off"
_BOUND = _T + "test_a_branch_ends_at_the_bound_of_the_interval"
_SHORTER = _T + "test_an_orbit_2T_ends_where_it_has_become_T"
_RIGID = _T + "test_a_branch_ends_where_rigid_bodies_graze"
_LIMIT = _T + "test_a_branch_ends_where_its_limit_is_touched"
_OFTEN = _T + "test_doublings_are_followed_as_often_as_asked"
_INDEX = _T + "test_a_special_point_lies_behind_the_point_of_its_index"
_RECALLED = _T + "test_what_is_recalled_is_not_computed_again"

MUTANTS = (
    *of(
        "nlds_vines/continuation/arclength.py",
        ("arclength: torus, the sign of 1", "mu[i] * mu[j] - 1.0", "mu[i] * mu[j] + 1.0", _TORUS),
        (
            "arclength: doubling, the sign of 1",
            "[m + 1.0 for m in mu]",
            "[m - 1.0 for m in mu]",
            _DOUBLING,
        ),
        (
            "arclength: a length is its square",
            "return math.sqrt(float((scaled * scaled).sum()))",
            "return float((scaled * scaled).sum())",
            _TANGENT,
        ),
        (
            "arclength: Newton goes away",
            "np.append(-cycle.gap, -off)",
            "np.append(cycle.gap, -off)",
            _NEWTON,
        ),
        (
            "arclength: an orbit closes roughly",
            "CLOSED, GOOD_ENOUGH = 1.0e-13",
            "CLOSED, GOOD_ENOUGH = 1.0e-6",
            _NEWTON,
        ),
        (
            "arclength: contraction upside down",
            "ratio = far / first",
            "ratio = first / far",
            _NEWTON,
        ),
        (
            "arclength: steps that grow go on",
            "if far > 2.0 * first:",
            "if far > 2.0e9 * first:",
            _T + "test_steps_that_grow_end_newton_at_once",
        ),
        (
            "arclength: a tangent of any length",
            "Point(cycle, tangent / size, weights,",
            "Point(cycle, tangent, weights,",
            _TANGENT,
        ),
        (
            "arclength: the length of the other tangent does not count",
            ".sum()) / length(a.weights, b.tangent)",
            ".sum())",
            _T + "test_the_angle_between_tangents_is_measured_by_weights",
        ),
        (
            "arclength: a step is longer than it may be",
            "step = min(self.step, most)",
            "step = self.step",
            _STEPS,
        ),
        (
            "arclength: steps never lengthen",
            "step * min(2.0, max(0.5",
            "step * min(1.0, max(0.5",
            _STEPS,
        ),
        ("arclength: no longest step", "min(self.longest, step *", "min(1.0, step *", _STEPS),
        (
            "arclength: sharp bends are taken",
            "if worst <= SHARPEST or shortest:",
            "if worst <= 8.0 * SHARPEST or shortest:",
            _T + "test_steps_shorten_where_a_branch_bends",
        ),
    ),
    *of(
        "nlds_vines/continuation/special_points.py",
        (
            "special: a torus explains one multiplier",
            '2 * ("NS" in kinds)',
            '1 * ("NS" in kinds)',
            _T + "test_two_multipliers_that_cross_at_once_are_seen_only_with_a_torus",
        ),
        (
            "special: a neutral saddle is a torus",
            'if kind == "NS" and not is_torus(point.cycle):',
            'if kind == "NS" and not point.cycle.n:',
            _TORUS,
        ),
        (
            "special: a branch point with all points on one side of it",
            "knots[4][0] * knots[5][0] < 0.0",
            "knots[4][0] * knots[5][0] > 0.0",
            _CROSSING,
        ),
        (
            "special: a branch point is any place",
            "at, before = limit_of(knots), limit_of(knots[2:])",
            "at, before = knots[0][1], limit_of(knots[2:])",
            _CROSSING,
        ),
        (
            "special: a doubling however far away",
            "while start is not None and aside <= most:",
            "while start is not None and aside <= 1.0:",
            _T + "test_a_doubling_is_looked_for_near_a_place_and_no_farther",
        ),
        (
            "special: of two labels the one with more impacts",
            'return min(int(label.split(",")[1])',
            'return max(int(label.split(",")[1])',
            _GRAZING,
        ),
        (
            "special: the other wall",
            'return "near" if before[0] != after[0] else "far"',
            'return "far" if before[0] != after[0] else "near"',
            _T + "test_the_wall_of_a_grazing_is_that_whose_impacts_change",
        ),
        (
            "special: one wall is both",
            "if before[0] != after[0] and before[1] != after[1]:",
            "if before[0] != after[0] or before[1] != after[1]:",
            _T + "test_the_wall_of_a_grazing_is_that_whose_impacts_change",
        ),
        (
            "special: a polynomial goes the other way",
            "(low * rows[i + 1] - high * rows[i]) / (low - high)",
            "(low * rows[i + 1] - high * rows[i]) / (high - low)",
            _T + "test_a_polynomial_has_its_value_at_zero",
        ),
        (
            "special: brackets are not halved",
            "halve = high - low > 0.5 * width",
            "halve = high - low > 2.0 * width",
            _NARROWED,
        ),
        (
            "special: a wide bracket is enough",
            "if high - low <= NARROW or",
            "if high - low <= 1.0e-6 or",
            _NARROWED,
        ),
        (
            "special: one sign is looked into",
            "if not f_low * f_high <= 0.0:",
            "if not f_low * f_high <= 1.0e9:",
            _NARROWED,
        ),
        (
            "special: a bracket has no width",
            "abs(residual), abs(values[1] - values[0])",
            "abs(residual), abs(values[1] - values[1])",
            _NARROWED,
        ),
    ),
    *of(
        "nlds_vines/continuation/branch.py",
        (
            "branch: no lower bound",
            "return self.low <= value <= self.high",
            "return value <= self.high",
            _BOUND,
        ),
        (
            "branch: the other bound",
            "bounds.low if b.value < bounds.low else bounds.high",
            "bounds.high if b.value < bounds.low else bounds.low",
            _BOUND,
        ),
        (
            "branch: the state comes first",
            "for i in range(size, -1, -1):",
            "for i in range(size + 1):",
            _TANGENT,
        ),
        (
            "branch: stable points count as unstable",
            "in_a_row + 1 if stepper.point.cycle.unstable else 0",
            "in_a_row + 1",
            _T + "test_an_unstable_branch_is_followed_no_further_than_asked",
        ),
        (
            "branch: a loop goes on",
            "    elif _is_back(arm, b):",
            "    elif not arm.points:",
            _T + "test_a_loop_is_closed",
        ),
        (
            "branch: back wherever it is near",
            "length(a.weights, aside) < 0.1 * step:",
            "length(a.weights, aside) < 1.0e9 * step:",
            _T + "test_a_loop_is_closed",
        ),
        (
            "branch: half an orbit is a whole one",
            "cycle.n // 2 - 1",
            "cycle.n - 1",
            _T + "test_halves_differ_by_what_they_differ_by",
        ),
        (
            "branch: it runs back on itself",
            "return far < SAME_ORBIT or (turned and far",
            "return far < SAME_ORBIT and (turned and far",
            _SHORTER,
        ),
        (
            "branch: it ends beyond the orbit of half its period",
            "if len({f for f, _ in knots}) < len(knots):",
            "if knots:",
            _SHORTER,
        ),
        (
            "branch: a graze adds what it takes",
            '(-1 if name == "slowest" else 1)',
            '(1 if name == "slowest" else -1)',
            _RIGID,
        ),
        (
            "branch: a graze is where the last orbit is",
            "place, before = limit_of(knots), limit_of(knots[1:])",
            "place, before = knots[-1][1], knots[-1][1]",
            _RIGID,
        ),
        (
            "branch: the end of a way is rough",
            "length(point.weights, place - before) > END_OF_WAY or",
            "length(point.weights, place - before) > 1.0e4 * END_OF_WAY or",
            _RIGID,
        ),
        ("branch: beyond the limit is before it", ".beyond[0] > 0.0)", ".beyond[0] < 0.0)", _LIMIT),
        (
            "branch: it ends beyond the limit",
            'arm.points[-1], arm.end = at, "limit"',
            'arm.end = "limit"',
            _LIMIT,
        ),
    ),
    *of(
        "nlds_vines/continuation/borders.py",
        (
            "borders: the end of a branch is a located point",
            "return None if point is None else point.value",
            "return value",
            _T + "test_what_ends_an_orbit_at_a_border_is_located_or_not_said",
        ),
        (
            "borders: what is known of an end is not asked",
            "return self.alive or any(kind in ENDING for kind, _ in self.events)",
            "return self.alive or not self.alive",
            _T + "test_what_ends_an_orbit_at_a_border_is_located_or_not_said",
        ),
    ),
    *of(
        "nlds_vines/continuation/exploration.py",
        (
            "exploration: one doubling whatever is asked",
            "default=1) * 2**self._search.doublings",
            "default=1) * 2",
            _OFTEN,
        ),
        (
            "exploration: an index of the branch without its first orbit",
            "[replace(s, index=s.index + 1) for s in arm.specials]",
            "[replace(s, index=s.index) for s in arm.specials]",
            _OFTEN,
        ),
        (
            "exploration: a branch does not begin with the orbit that doubles",
            "if first is not None:  #",
            "if first is None:  #",
            _OFTEN,
        ),
        (
            "exploration: a known branch again",
            "if cycle is None or self.lies_on(cycle) is not None:",
            "if cycle is None:",
            _T + "test_a_start_on_a_known_branch_is_not_followed_again",
        ),
        (
            "exploration: another phase is another orbit",
            "return bool(off.max(axis=1).min() < SAME_ORBIT)",
            "return bool(off.max() < SAME_ORBIT)",
            _T + "test_orbits_are_one_at_whatever_phase",
        ),
        (
            "exploration: a track is crossed at its points",
            "share = (value - a.value) / step if step else 0.0",
            "share = 0.0",
            _T + "test_a_track_is_crossed_where_it_has_the_parameter",
        ),
        (
            "exploration: what is recalled is computed",
            "track = make() if arrays is None else unpacked(arrays)",
            "track = make()",
            _RECALLED,
        ),
        (
            "exploration: a loop in both directions",
            'if arms[0].end == "closed":\n                return Track(arms[0].points, arms[0].specials, ("closed", "closed"))',
            'if arms[0].end == "never":\n                return Track(arms[0].points, arms[0].specials, ("closed", "closed"))',
            _T + "test_a_closed_branch_is_followed_once",
        ),
    ),
    *of(
        "nlds_vines/continuation/switching.py",
        (
            "switching: a doubling leads back",
            "aside, 2 * cycle.n)",
            "aside, cycle.n)",
            _T + "test_a_doubling_leads_to_the_orbit_2T",
        ),
        (
            "switching: a null vector of any length",
            "found = solution[:-1] / math.sqrt(float((solution[:-1] * solution[:-1]).sum()))",
            "found = solution[:-1]",
            _T + "test_a_null_vector_is_hardly_changed",
        ),
    ),
    *of(
        "nlds_vines/continuation/track.py",
        (
            "track: a point turned keeps its tangent",
            "Point(point.cycle, -point.tangent, point.weights, -point.border)",
            "Point(point.cycle, point.tangent, point.weights, -point.border)",
            _T + "test_both_directions_of_a_start_are_one_track",
        ),
        (
            "track: an index of the first half, one off",
            "before - 1 - s.index",
            "before - s.index",
            _INDEX,
        ),
        (
            "track: an index of the second half, from its own start",
            "index=before + s.index",
            "index=s.index",
            _INDEX,
        ),
        (
            "track: labels in the old direction",
            "before=special.after,\n        after=special.before,",
            "before=special.before,\n        after=special.after,",
            _INDEX,
        ),
        (
            "track: a doubling is read as a branch point",
            '("start", "PD", "BP")[origin], parent',
            '("start", "BP", "PD")[origin], parent',
            _RECALLED,
        ),
    ),
)
