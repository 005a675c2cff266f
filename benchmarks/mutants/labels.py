"""Mutants: lifetimes, motion without contact, labels, evidence, spectra, requests."""

from __future__ import annotations

from benchmarks.mutants.mutant import of

_T_SCAN = "tests/bifurcation/test_scan.py::"
_T_SURVIVAL_CURVE = "tests/transients/test_survival_curve.py::"
_T_TRANSIENTS = "tests/transients/test_transients.py::"
_T_LINEAR_RESPONSE = "tests/model/test_linear_response.py::"
_T_EVIDENCE = "tests/orbits/test_evidence.py::"
_T_COEXISTENCE = "tests/orbits/test_coexistence.py::"
_T_SPECTRUM = "tests/orbits/test_spectrum.py::"
_PLAIN_METHODS = "tests/property/plain_methods.py::"

MUTANTS = (
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
            '"sampling": entries(self, "sampling"),',
            '"sampling": dict(list(entries(self, "sampling").items())[1:]),',
            _T_SCAN + "test_hash_sees_whatever_changes_numbers",
        ),
        (
            "request: the last value of an axis is not checked",
            "axis.values[[0, -1]] for axis in self.axes",
            "axis.values[[0, 0]] for axis in self.axes",
            _T_SCAN + "test_both_ends_of_an_axis_are_checked",
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
