"""Mutants: sweeps, starts, refined settings and errors, objectives of searches."""

from __future__ import annotations

from benchmarks.mutants.mutant import of

_PLAIN_SWEEPS = "tests/bifurcation/plain_sweeps.py::"
_T_ENERGIES = "tests/reference/test_energies.py::"
_T_DETERMINISM = "tests/contract/test_determinism.py::"
_T_SCAN = "tests/bifurcation/test_scan.py::"
_T_REFINEMENT = "tests/orbits/test_refinement.py::"
_T_CELL_ORBIT = "tests/bifurcation/test_cell_orbit.py::"
_T_TUNING = "tests/tuning/test_tuning.py::"

MUTANTS = (
    *of(
        "nlds_vines/bifurcation/cell_start.py",
        (
            "cell_start: a downward sweep goes up",
            'STEP = {"up": 1, "down": -1}',
            'STEP = {"up": 1, "down": 1}',
            _PLAIN_SWEEPS
            + "test_every_link_begins_where_the_one_before_ended[a linear damper, k2-down]",
        ),
        (
            "cell_start: every orbit of a cell has the first draw",
            "if draws is None else draws)[lanes]",
            "if draws is None else draws)[0 * lanes]",
            _T_CELL_ORBIT + "test_the_states_that_were_drawn_are_stored",
        ),
    ),
    *of(
        "nlds_vines/bifurcation/compute.py",
        (
            "compute: results of a downward sweep are not turned round",
            "ordered = (one[:, :: STEP[sweep]] for one, sweep in zip(passes, sweeps, strict=True))",
            "ordered = (one[:, :] for one, sweep in zip(passes, sweeps, strict=True))",
            _PLAIN_SWEEPS
            + "test_every_link_begins_where_the_one_before_ended[a linear damper, k2-down]",
        ),
        (
            "compute: the impact rate counts the near wall alone",
            "outputs.counts.sum(axis=-1) / self.scan.periods",
            "outputs.counts[..., 0] / self.scan.periods",
            _PLAIN_SWEEPS + "test_impacts_are_counted_by_wall",
        ),
        (
            "compute: the reduction is not relative",
            '1.0 - arrays["E1max"] / energy_alone(cells)',
            '1.0 - arrays["E1max"]',
            _T_ENERGIES + "test_the_reduction_is_measured_by_the_structure_alone",
        ),
        (
            "compute: failed lanes keep their numbers",
            "        values[failed] = dataset.fill",
            "        values[failed] = values[failed]",
            _T_DETERMINISM
            + "test_a_failed_lane_is_marked_and_leaves_its_neighbours_alone[too stiff-rest]",
        ),
    ),
    *of(
        "nlds_vines/orbits/starts.py",
        (
            "starts: random states are not held between the walls",
            '        r = np.minimum(r, cells["near"][..., np.newaxis])',
            "        r = np.minimum(r, 1e9)",
            _T_SCAN + "test_random_states_stay_between_the_walls",
        ),
        (
            "starts: random states beyond the far wall stay",
            '        r = np.maximum(r, -cells["far"][..., np.newaxis])',
            "        r = np.maximum(r, -1e9)",
            _T_SCAN + "test_random_states_stay_between_the_walls",
        ),
        (
            "starts: random states beyond a limit stay",
            "        r = np.where(r > limit, 2 * limit - r, r)",
            "        r = np.where(r > limit, limit, r)",
            _T_SCAN + "test_random_states_beyond_a_limit_are_mirrored_at_it",
        ),
        (
            "starts: more starts of a seed begin otherwise",
            "generator = np.random.default_rng(start.seed)",
            "generator = np.random.default_rng([start.seed, start.orbits])",
            _T_SCAN + "test_draws_depend_on_the_seed_alone",
        ),
        (
            "starts: random speeds do not scale with the frequency",
            'speed = length * cells["omega"][..., np.newaxis]',
            "speed = length",
            _T_SCAN + "test_random_states_measure_in_static_deflections",
        ),
    ),
    *of(
        "nlds_vines/orbits/refinement.py",
        (
            "refinement: the error is that of the first period",
            "return _apart(found, ends).max(axis=2)",
            "return _apart(found, ends)[:, :, 0]",
            _T_REFINEMENT + "test_the_error_is_the_largest_of_the_periods",
        ),
        (
            "refinement: periods begin where they end",
            "known = section[:, :, -count - 1 : -1]",
            "known = section[:, :, -count:]",
            _T_REFINEMENT + "test_periods_begin_where_the_orbit_was",
        ),
        (
            "refinement: the rest offset is left out of a begin",
            "later[..., 2] = known[..., 0] - (known[..., 2] - rest[..., np.newaxis])",
            "later[..., 2] = known[..., 0] - known[..., 2]",
            _T_REFINEMENT + "test_periods_begin_where_the_orbit_was",
        ),
        (
            "refinement: a label that differs is kept",
            'np.where(label == refined, KEPT["yes"], KEPT["no"])',
            'np.where(label != \'\', KEPT["yes"], KEPT["no"])',
            _T_REFINEMENT + "test_a_label_is_kept_where_kind_and_final_orbit_are",
        ),
        (
            "refinement: where the refined run failed the error is a number",
            '"error_at_end": np.where(sound, apart, np.nan)}',
            '"error_at_end": apart}',
            _T_REFINEMENT + "test_where_only_the_refined_run_fails_nothing_is_made_up",
        ),
        (
            "refinement: the largest difference is that of positions",
            "return np.abs(one - other).max(axis=-1)",
            "return np.abs(one - other)[..., 0]",
            _T_REFINEMENT + "test_the_error_is_the_largest_of_the_periods",
        ),
    ),
    *of(
        "nlds_vines/orbits/settings.py",
        (
            "settings: refined settings of rk4 are the same",
            "return Settings.rk4(self.period_steps * 2)",
            "return Settings.rk4(self.period_steps)",
            _T_REFINEMENT + "test_a_coarse_method_tells_a_larger_error",
        ),
        (
            "settings: a refined run may have the same nodes",
            "nodes=min(max(REFINED_NODES, (self.nodes or 0) + 4), MOST_NODES)",
            "nodes=self.nodes",
            "tests/reference/test_error_estimate.py::"
            "test_refined_settings_are_those_the_documentation_names",
        ),
        (
            "settings: a tolerance beside rk4 is passed over",
            '        if (name in _OF_RK4) != (method == "rk4"):\n',
            '        if name in _OF_RK4 and method != "rk4":\n',
            "tests/orbits/test_settings.py::test_every_method_has_its_own_settings",
        ),
    ),
    *of(
        "nlds_vines/tuning/objective.py",
        (
            "objective: the objective is that of the first case",
            "case = value.argmax(axis=1)",
            "case = 0 * value.argmax(axis=1)",
            _T_TUNING + "test_one_failed_case_condemns_a_design_and_no_number_is_made_of_it",
        ),
        (
            "objective: a design that fails has an objective",
            "value = np.where(outcome.inadmissible, np.inf, outcome.objective)",
            "value = outcome.objective",
            _T_TUNING + "test_one_failed_case_condemns_a_design_and_no_number_is_made_of_it",
        ),
        (
            "objective: a perturbed frequency is not perturbed",
            'grid["omega"] = grid["omega"] * trials.detuning[:, np.newaxis]',
            'grid["omega"] = grid["omega"] * np.ones_like(trials.detuning[:, np.newaxis])',
            _T_TUNING + "test_a_perturbed_trial_is_the_perturbed_system",
        ),
        (
            "objective: random starts are those of one",
            "which = trials.start[moved].astype(int) - 1",
            "which = 0 * trials.start[moved].astype(int)",
            _T_TUNING + "test_a_start_of_its_own_is_used",
        ),
        (
            "objective: no more periods are computed for a stretch",
            "periods = (round(n * stretch) for n in (self._tuning.transient, self._tuning.periods))",
            "periods = (round(n) for n in (self._tuning.transient, self._tuning.periods))",
            _T_TUNING + "test_more_periods_tell_what_had_not_settled",
        ),
    ),
    *of(
        "nlds_vines/orbits/batch.py",
        (
            "batch: a broken constraint is admissible",
            "return (self.status != OK) | ~np.isfinite(self.objective) | (self.violations > 0)",
            "return (self.status != OK) | ~np.isfinite(self.objective)",
            _T_TUNING + "test_a_broken_constraint_condemns_a_design",
        ),
        (
            "batch: an energy that is no number is admissible",
            "return (self.status != OK) | ~np.isfinite(self.objective) | (self.violations > 0)",
            "return (self.status != OK) | (self.violations > 0)",
            _T_TUNING + "test_one_failed_case_condemns_a_design_and_no_number_is_made_of_it",
        ),
    ),
)
