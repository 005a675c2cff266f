"""Mutants: sweeps, starts, errors, searches, lifetimes, what is known without impacts, words."""

from __future__ import annotations

from benchmarks.mutants.mutant import of

_PLAIN_SWEEPS = "tests/bifurcation/plain_sweeps.py::"
_T_ENERGIES = "tests/reference/test_energies.py::"
_T_DETERMINISM = "tests/contract/test_determinism.py::"
_T_SCAN = "tests/bifurcation/test_scan.py::"
_T_REFINEMENT = "tests/orbits/test_refinement.py::"
_T_TUNING = "tests/tuning/test_tuning.py::"
_T_SURVIVAL_CURVE = "tests/transients/test_survival_curve.py::"
_T_TRANSIENTS = "tests/transients/test_transients.py::"
_T_LINEAR_RESPONSE = "tests/model/test_linear_response.py::"
_T_EVIDENCE = "tests/orbits/test_evidence.py::"
_T_COEXISTENCE = "tests/orbits/test_coexistence.py::"
_T_SPECTRUM = "tests/orbits/test_spectrum.py::"
_PLAIN_METHODS = "tests/property/plain_methods.py::"

MUTANTS = (
    *of(
        "nlds_vines/bifurcation/compute.py",
        (
            "compute: a downward sweep goes up",
            'STEP = {"up": 1, "down": -1}',
            'STEP = {"up": 1, "down": 1}',
            _PLAIN_SWEEPS
            + "test_every_link_begins_where_the_one_before_ended[a linear damper, k2-down]",
        ),
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
    ),
    *of(
        "nlds_vines/tuning/objective.py",
        (
            "objective: the objective is that of the first case",
            "case = energy.argmax(axis=1)",
            "case = 0 * energy.argmax(axis=1)",
            _T_TUNING + "test_one_failed_case_condemns_a_design_and_no_number_is_made_of_it",
        ),
        (
            "objective: a design that fails has an objective",
            "energy = np.where(outcome.inadmissible, np.inf, outcome.E1max)",
            "energy = outcome.E1max",
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
            "return (self.status != OK) | ~np.isfinite(self.E1max) | (self.violations > 0)",
            "return (self.status != OK) | ~np.isfinite(self.E1max)",
            _T_TUNING + "test_a_broken_constraint_condemns_a_design",
        ),
        (
            "batch: an energy that is no number is admissible",
            "return (self.status != OK) | ~np.isfinite(self.E1max) | (self.violations > 0)",
            "return (self.status != OK) | (self.violations > 0)",
            _T_TUNING + "test_one_failed_case_condemns_a_design_and_no_number_is_made_of_it",
        ),
    ),
    *of(
        "nlds_vines/transients/survival.py",
        (
            "survival: a quantile is the time after it",
            "np.flatnonzero(self.share <= 1.0 - q + 1e-12)",
            "np.flatnonzero(self.share < 1.0 - q - 1e-12)",
            _T_SURVIVAL_CURVE + "test_without_censoring_it_is_the_share_that_is_left",
        ),
        (
            "survival: those at risk are counted after their time",
            "np.searchsorted(np.sort(times), falls)",
            "np.searchsorted(np.sort(times), falls, side='right')",
            _T_SURVIVAL_CURVE + "test_the_textbook_example",
        ),
        (
            "survival: the rate counts the time before the delay",
            "float((times[beyond] - delay).sum())",
            "float(times[beyond].sum())",
            _T_SURVIVAL_CURVE + "test_the_rate_is_deaths_over_exposure_beyond_the_delay",
        ),
        (
            "survival: lifetimes before the delay count as ended",
            "int(ended[beyond].sum())",
            "int(ended.sum())",
            _T_SURVIVAL_CURVE + "test_the_rate_is_deaths_over_exposure_beyond_the_delay",
        ),
        (
            "survival: the upper end of the rate's interval has the lower's count",
            "chi2.ppf(1.0 - tail, 2 * count + 2)",
            "chi2.ppf(1.0 - tail, 2 * count)",
            _T_SURVIVAL_CURVE + "test_the_rate_is_deaths_over_exposure_beyond_the_delay",
        ),
    ),
    *of(
        "nlds_vines/transients/ensemble.py",
        (
            "ensemble: what failed has a lifetime",
            '_NO_LIFETIME = ("failed", "quasiperiodic", "")',
            '_NO_LIFETIME = ("quasiperiodic", "")',
            _T_TRANSIENTS + "test_what_has_a_lifetime_counts_and_what_was_watched_is_censored",
        ),
        (
            "ensemble: a lifetime that was not watched to its end has ended",
            "return (self.settling >= 0)[self.counted]",
            "return (self.settling >= -1)[self.counted]",
            _T_TRANSIENTS + "test_what_has_a_lifetime_counts_and_what_was_watched_is_censored",
        ),
    ),
    *of(
        "nlds_vines/model/linear_response.py",
        (
            "linear response: the dashpot of the joint is left out",
            'joint = p["k2"] + 1j * omega * p["c2"]',
            'joint = p["k2"] + 0j * omega * p["c2"]',
            _T_LINEAR_RESPONSE + "test_amplitudes_at_any_frequency",
        ),
        (
            "linear response: clearance looks at one wall",
            "return self.shortening <= min(gaps)",
            "return self.shortening <= gaps[0]",
            _T_LINEAR_RESPONSE + "test_the_nearer_wall_decides_whether_it_clears",
        ),
        (
            "linear response: the steady state rests at zero",
            "        state[2] += system.rest",
            "        state[2] += 0.0",
            _T_LINEAR_RESPONSE + "test_the_steady_state_returns_after_a_period",
        ),
        (
            "linear response: the damper's row of the flow has the structure's sign",
            'np.array([p["k2"], p["c2"], -p["k2"], -p["c2"]]) / p["m2"]',
            'np.array([p["k2"], p["c2"], -p["k2"], p["c2"]]) / p["m2"]',
            _T_LINEAR_RESPONSE + "test_the_steady_state_returns_after_a_period",
        ),
        (
            "linear response: a resonance without damping has an amplitude",
            "np.where(force == 0, 0, np.inf)",
            "np.where(force == 0, 0, 0.0)",
            _T_LINEAR_RESPONSE + "test_a_resonance_without_damping_has_no_steady_state",
        ),
    ),
    *of(
        "nlds_vines/orbits/labels.py",
        (
            "labels: a transient is told as its end",
            'before = TRANSIENT if regime == FLAGS["transient_chaos"] else ""',
            'before = ""',
            _T_EVIDENCE + "test_words_of_every_kind",
        ),
        (
            "labels: a failed lane has a verdict",
            'np.where(status == codes.OK, kind, FLAGS["failed"])',
            'np.where(status >= codes.OK, kind, FLAGS["failed"])',
            _T_EVIDENCE + "test_words_of_every_kind",
        ),
    ),
    *of(
        "nlds_vines/orbits/evidence.py",
        (
            "evidence: exponents of a cycle are per period of the forcing",
            "of_cycle = logarithms / (rows[..., ev.PERIOD] * period)[..., np.newaxis]",
            "of_cycle = logarithms / period[..., np.newaxis]",
            _T_EVIDENCE + "test_exponents_of_a_cycle_are_those_of_its_multipliers",
        ),
        (
            "evidence: the point of an orbit forgets the rest offset",
            "found[..., 2] = y[..., 0] - y[..., 2] + rest",
            "found[..., 2] = y[..., 0] - y[..., 2]",
            _T_EVIDENCE + "test_points_are_in_the_users_coordinates",
        ),
        (
            "evidence: impacts of a cycle are those of the window",
            "by_wall = np.where((period > 0)[..., np.newaxis], of_cycle, counts).astype(np.int64)",
            "by_wall = np.where((period > 9)[..., np.newaxis], of_cycle, counts).astype(np.int64)",
            _T_EVIDENCE + "test_labels_count_impacts_of_a_cycle_or_of_the_window",
        ),
        (
            "evidence: lanes that failed keep their evidence",
            "rows = np.where((status == OK)[..., np.newaxis], rows, np.nan)",
            "rows = rows.copy()",
            _T_EVIDENCE + "test_a_lane_that_failed_keeps_no_evidence",
        ),
    ),
    *of(
        "nlds_vines/orbits/coexistence.py",
        (
            "coexistence: chaos that one start has left counts",
            "        present[..., classes.index(CHAOS)] &= ~left.any(axis=-1)\n",
            "",
            _T_COEXISTENCE + "test_coexisting_regimes_are_counted_and_gaps_in_knowledge_are_not",
        ),
        (
            "coexistence: an unknown label may stand for a cell",
            "everywhere * ~np.isin(classes, UNKNOWN)",
            "everywhere",
            _T_COEXISTENCE + "test_of_equally_many_a_known_one_stands_for_a_cell",
        ),
    ),
    *of(
        "nlds_vines/orbits/spectrum.py",
        (
            "spectrum: the Nyquist frequency counts twice",
            "sides[-1] = 1.0 if count % 2 == 0 else 2.0",
            "sides[-1] = 2.0",
            _T_SPECTRUM + "test_the_nyquist_frequency_counts_once",
        ),
    ),
    *of(
        "nlds_vines/orbits/signals.py",
        (
            "signals: the damper's energy is that of its stretch",
            "p, w = system.parameters, states[:, 2] - system.rest",
            "p, w = system.parameters, states[:, 2] - states[:, 0] - system.rest",
            _PLAIN_METHODS + "test_the_largest_energies_are_those_of_many_samples",
        ),
    ),
    *of(
        "nlds_vines/model/axis.py",
        (
            "axis: equal values are allowed",
            "equal = values[1:][np.diff(values) == 0]",
            "equal = values[:0]",
            _T_SCAN + "test_equal_values_of_an_axis_are_refused",
        ),
    ),
    *of(
        "nlds_vines/bifurcation/request.py",
        (
            "request: a scan's hash forgets how long it runs",
            '"sampling": {name: getattr(self, name) for name in SAMPLING},',
            '"sampling": {name: getattr(self, name) for name in list(SAMPLING)[1:]},',
            _T_SCAN + "test_hash_sees_whatever_changes_numbers",
        ),
        (
            "request: the last value of an axis is not checked",
            "axis.values[[0, -1]] for axis in self.axes",
            "axis.values[[0, 0]] for axis in self.axes",
            _T_SCAN + "test_contradictions_name_their_places",
        ),
    ),
    *of(
        "nlds_vines/bifurcation/blocks.py",
        (
            "blocks: an axis that is followed is cut",
            "along = last if scan.start.sweeps else min(last, cells)",
            "along = min(last, cells)",
            _T_SCAN + "test_an_axis_that_is_followed_stays_whole",
        ),
    ),
)
