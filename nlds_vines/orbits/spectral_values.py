"""The values of `spectral_records`, from states at equal steps.

Performance: of 240 periods of 64 states, a spectrum takes 0.4 ms, and so does its background.
"""

from __future__ import annotations

import numpy as np

from nlds_vines.kernels.orbit.repetition import REPEATS, TOLERANCE, period_of
from nlds_vines.model.labels import FLAGS, KEPT
from nlds_vines.orbits.spectral_records import LINES, SpectralRecords
from nlds_vines.orbits.spectrum import spectrum_of

UNCLEAR = "unclear"
"""The spectral label of what is neither lines nor broadband."""

LINES_BELOW, BROADBAND_ABOVE = 1e-4, 1e-3
"""Broadband shares of lines alone and of continuous spectra.

Set 6 between 7.363 and 7.425 rad/s, 19 quasiperiodic motions and 13 chaotic ones: see
`docs/portrait.md#spectra-along-a-scan`."""

FEWEST_PERIODS = 120
"""Sampled periods from which on the broadband share separates regimes. With 60, lines are so near
each other that 14 of 19 quasiperiodic motions have shares above `BROADBAND_ABOVE`, with 90 two of
18, with 120 none (at most 7.3e-4)."""


def spectral_label(n: int, share: float, periods: int) -> str:
    """Return the label of an orbit by its spectra alone, sampled over `periods`.

    `nT` if the section recurs. Otherwise the broadband `share` decides, if the periods suffice.
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
    """Return where verdicts and spectra agree, codes of `labels.KEPT`; -1 where one cannot tell.

    Arguments: codes of the `regime`, the `period` n of nT and the spectral labels, of one shape;
    the number of sampled `periods`.
    An nT orbit agrees with nT, a quasiperiodic one with lines, chaos with a broadband spectrum.
    An orbit whose period is longer than a third of the sampled ones cannot recur (`period_of`).
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
    """Return the datasets by name, (chains, links, ...) each; NaN where orbits failed.

    Arguments: what is recorded; `states` (chains, links, periods samples, components), the last of
    each period at its end; `sound` (chains, links), which of them mean something; the `transient`
    before.
    """
    arrays = _unknown(records, sound.shape)
    for lane in zip(*np.nonzero(sound), strict=True):
        of_orbit = states[lane]
        section = np.ascontiguousarray(of_orbit[records.samples - 1 :: records.samples])
        n = int(period_of(section, TOLERANCE))
        if "lines" in records.want:
            arrays["line_period"][lane] = n
        for i, name in enumerate(records.signals):
            values, here = _signal(records, name, of_orbit), (*lane, i)
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


def _unknown(records: SpectralRecords, shape: tuple[int, ...]) -> dict[str, np.ndarray]:
    """Return the wanted datasets of orbits of a `shape`, without a value each."""
    of_each, arrays = (*shape, len(records.signals)), dict[str, np.ndarray]()
    if "spectrum" in records.want:
        arrays["spectrum"] = np.full((*of_each, records.bins), np.nan)
    if "lines" in records.want:
        arrays["line_period"] = np.zeros(shape, np.int32)
        for name in ("line_amplitude", "line_phase"):
            arrays[name] = np.full((*of_each, LINES), np.nan)
    if "broadband" in records.want:
        arrays["broadband"] = np.full(of_each, np.nan)
        arrays["spectral_label"] = np.full(shape, "", "<U16")
    return arrays


def _signal(records: SpectralRecords, name: str, of_orbit: np.ndarray) -> np.ndarray:
    if name == "u":
        return of_orbit[:, 2] - of_orbit[:, 0]
    return np.ascontiguousarray(of_orbit[:, records.scene.components.index(name)])


def _lines(
    records: SpectralRecords, values: np.ndarray, n: int, transient: int
) -> tuple[np.ndarray, np.ndarray]:
    """Return amplitudes and phases (LINES,) of a signal of an nT orbit.

    Of as many of the last periods as make whole cycles: then each line stands on a bin, and
    nothing leaks.
    """
    cycles = records.periods // n
    last = values[-cycles * n * records.samples :]
    spectrum = np.fft.rfft(last) * (2.0 / last.size)
    numbers = np.arange(1, LINES + 1)
    bins = numbers * cycles
    there = bins < spectrum.size - 1  # below the Nyquist frequency
    lines = np.where(there, spectrum[np.minimum(bins, spectrum.size - 1)], np.nan)
    first = (transient + records.periods - cycles * n) * records.samples + 1
    turns = numbers * first / (n * records.samples)  # of the line, from t = 0 to its first sample
    angle = np.angle(lines) - 2.0 * np.pi * (turns % 1.0)
    return np.abs(lines), np.where(there, -((np.pi - angle) % (2.0 * np.pi) - np.pi), np.nan)
