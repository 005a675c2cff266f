"""The spectrum of an orbit, and the values of the spectral records, from equidistant states.

A spectrum of 240 periods with 64 states each takes 0.4 ms; its background takes as long.
"""

from __future__ import annotations

import numpy as np

from nlds_vines.errors import RequestError, shown
from nlds_vines.kernels.orbit.repetition import REPEATS, TOLERANCE, period_of
from nlds_vines.model.labels import FLAGS, KEPT
from nlds_vines.orbits.simulation import Orbit
from nlds_vines.orbits.spectrum import (
    LINES,
    SIGNALS,
    SpectralRecords,
    Spectrum,
    checked_signal,
    spectrum_of,
)

# the spectral label if the broadband share, or too few sampled periods, does not decide
UNCLEAR = "unclear"

# A smaller broadband share means lines alone; a share above the second, a continuous spectrum.
# From 19 quasiperiodic and 13 chaotic motions of Set 6 between 7.363 and 7.425 rad/s: see
# `docs/portrait.md#spectra-along-a-scan`.
LINES_BELOW, BROADBAND_ABOVE = 1e-4, 1e-3

# Least number of sampled periods for which the broadband share separates regimes.  With 60, lines
# are so close that 14 of 19 quasiperiodic motions have shares above `BROADBAND_ABOVE`, with 90 two
# of 18, with 120 none (at most 7.3e-4).
FEWEST_PERIODS = 120


def spectrum(orbit: Orbit, signal: str = "x1", *, window: str = "rectangular") -> Spectrum:
    """Return the spectrum of a signal along an orbit.

    Parameters
    ----------
    orbit : Orbit
        From `simulate` with "trajectory" in `record`.  If an nT orbit is recorded over a multiple
        of n periods, each line lies on a bin and none leaks.
    signal : str
        A component of the state, x1, v1, x2, v2 [m, m/s]; u = x2 - x1 [m]; the contact `force` on
        the damper [N]; an energy, E1 or E2 [J].
    window : str
        "rectangular" or "hann".

    Returns
    -------
    Spectrum
        Amplitude and power over the order, the frequency over that of the force.

    Raises
    ------
    RequestError
        If the orbit has no trajectory, or the scene lacks the signal.

    Notes
    -----
    512 samples per period, the default of `simulate`, suffice for states: aliasing onto their lines
    is below 1e-9 m.  A contact lasts 16 to 24 ms, a fiftieth of a period, and the spectrum of its
    force is wide: with 512 samples the error is 2e-3 of its largest line, with 1024 4e-4, with 4096
    1e-5 (SSul Set 6, 7.375 rad/s).

    Examples
    --------
    >>> import nlds_vines as nv
    >>> system = nv.load_system("ssul-set6", omega=5.5)
    >>> record = ["trajectory", "impacts"]
    >>> orbit = nv.simulate(system, 8, transient=200, record=record, quiet=True)
    >>> lines = nv.spectrum(orbit, "x1")
    >>> float(lines.order[1 + lines.amplitude[1:].argmax()])
    1.0
    """
    if not hasattr(orbit, "trajectory"):
        raise RequestError(f"orbit = {shown(orbit)} must be an Orbit, as simulate returns it")
    checked_signal(signal, orbit.system.scene)
    if orbit.trajectory is None or orbit.time is None:
        raise RequestError("the orbit holds no trajectory: simulate with record=['trajectory']")
    if len(orbit.time) < 2:
        raise RequestError("a trajectory of one state has no spectrum: record more periods")
    step = (orbit.time[-1] - orbit.time[0]) / (len(orbit.time) - 1)
    return spectrum_of(
        SIGNALS[signal].of(orbit.system, orbit.trajectory),
        round(orbit.system.period / step),
        orbit.system.parameters["omega"],
        window=window,
        quantity=signal,
        unit=SIGNALS[signal].unit,
    )


# ---- records of scans ----


def spectral_label(n: int, share: float, periods: int) -> str:
    """Return the label of an orbit by its spectra alone, sampled over `periods`.

    It is `nT` if the section recurs.  Otherwise the broadband `share` decides, if there are enough
    periods.
    """
    if n:
        return f"{n}T" if n > 1 else "T"
    if periods < FEWEST_PERIODS:
        return UNCLEAR
    if share < LINES_BELOW:
        return "lines"
    return "broadband" if share > BROADBAND_ABOVE else UNCLEAR


def agreement(
    regime: np.ndarray, period: np.ndarray, spectral_labels: np.ndarray, periods: int
) -> np.ndarray:
    """Return whether verdicts and spectra agree: codes of `labels.KEPT`, -1 if undecided.

    Arguments: codes of the `regime`, the `period` n of nT and the spectral labels, of one shape;
    the number of sampled `periods`.
    An nT orbit agrees with nT, a quasiperiodic one with lines, chaos with a broadband spectrum.
    It is undecided if n exceeds a third of `periods`: `period_of` finds no such recurrence.
    """
    words = {FLAGS["quasiperiodic"]: "lines", FLAGS["chaotic"]: "broadband"}
    agreed = np.full(regime.shape, -1, np.int8)
    for place in np.ndindex(regime.shape):
        n, says = int(period[place]), str(spectral_labels[place])
        expected = spectral_label(n, 0.0, periods) if n else words.get(int(regime[place]), "")
        if REPEATS * n > periods:
            continue
        if expected and says not in ("", UNCLEAR):
            agreed[place] = KEPT["yes" if says == expected else "no"]
    return agreed


def arrays_of(
    records: SpectralRecords, states: np.ndarray, sound: np.ndarray, transient: int
) -> dict[str, np.ndarray]:
    """Return the datasets by name, (sweeps, cells, ...) each. Orbits that failed have NaN,
    `line_period` 0 and `spectral_label` "".

    Arguments: the `records`; `states` (sweeps, cells, periods samples, components), the last of
    each period at its end; `sound` (sweeps, cells), False for orbits that failed; the `transient`
    before.
    """
    shape, arrays = sound.shape, dict[str, np.ndarray]()
    of_each = (*shape, len(records.signals))
    if "spectrum" in records.want:
        arrays["spectrum"] = np.full((*of_each, records.bins), np.nan)
    if "lines" in records.want:
        arrays["line_period"] = np.zeros(shape, np.int32)
        for name in ("line_amplitude", "line_phase"):
            arrays[name] = np.full((*of_each, LINES), np.nan)
    if "broadband" in records.want:
        arrays["broadband"] = np.full(of_each, np.nan)
        arrays["spectral_label"] = np.full(shape, "", "<U16")
    for lane in zip(*np.nonzero(sound), strict=True):
        of_orbit = states[lane]
        section = np.ascontiguousarray(of_orbit[records.samples - 1 :: records.samples])
        n = int(period_of(section, TOLERANCE))
        if "lines" in records.want:
            arrays["line_period"][lane] = n
        for i, name in enumerate(records.signals):
            here = (*lane, i)
            if name == "u":
                values = of_orbit[:, 2] - of_orbit[:, 0]
            else:
                column = records.scene.components.index(name)
                values = np.ascontiguousarray(of_orbit[:, column])
            if "spectrum" in records.want:
                whole = spectrum_of(values, records.samples, 1.0, window=records.window)
                arrays["spectrum"][here] = whole.amplitude[: records.bins]
            if "broadband" in records.want:
                tapered = spectrum_of(values, records.samples, 1.0, window="hann")
                arrays["broadband"][here] = tapered.background_share(records.bins)
            if "lines" in records.want and n:
                amplitude, phase = _lines(records, values, n, transient)
                arrays["line_amplitude"][here], arrays["line_phase"][here] = amplitude, phase
        if "broadband" in records.want:
            arrays["spectral_label"][lane] = spectral_label(
                n, arrays["broadband"][lane].max(), len(section)
            )
    return arrays


def _lines(
    records: SpectralRecords, values: np.ndarray, n: int, transient: int
) -> tuple[np.ndarray, np.ndarray]:
    """Return amplitudes and phases (LINES,) of a signal of an nT orbit.

    They are taken over the last whole cycles of n periods, so that each line lies on a bin and
    none leaks.
    """
    cycles = records.periods // n
    last = values[-cycles * n * records.samples :]
    spectrum = np.fft.rfft(last) * (2.0 / last.size)
    numbers = np.arange(1, LINES + 1)
    bins = numbers * cycles
    is_below_nyquist = bins < spectrum.size - 1
    lines = np.where(is_below_nyquist, spectrum[np.minimum(bins, spectrum.size - 1)], np.nan)
    first = (transient + records.periods - cycles * n) * records.samples + 1
    turns = numbers * first / (n * records.samples)  # of the line, from t = 0 to its first sample
    angle = np.angle(lines) - 2.0 * np.pi * (turns % 1.0)
    phases = -((np.pi - angle) % (2.0 * np.pi) - np.pi)  # in (-pi, pi]
    return np.abs(lines), np.where(is_below_nyquist, phases, np.nan)
