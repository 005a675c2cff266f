"""The Lyapunov spectrum of one orbit with its convergence: all exponents with intervals.

The variations of an orbit are propagated from section to section by the derivative of the
stroboscopic map, exact in flight and through contacts, and orthonormalized after each period.  The
verdicts of scans measure the largest exponent with its interval in `kernels.cells.verdict`.

Source: Benettin, Galgani, Giorgilli, Strelcyn, Meccanica 15 (1980) 9 and 21.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from nlds_vines.archives.representation import Outlined, Rows
from nlds_vines.errors import whole
from nlds_vines.kernels.cells import cycles
from nlds_vines.kernels.cells.verdict import BATCHES, QUANTILE
from nlds_vines.kernels.scene.codes import OK
from nlds_vines.model.system import System
from nlds_vines.orbits.compilation import Compilation, Needed, notice
from nlds_vines.orbits.kernel_inputs import parts_of
from nlds_vines.orbits.simulation import IntegrationError, start_state
from nlds_vines.orbits.solver_settings import Settings
from nlds_vines.runs.interrupts import stoppable

PERIODS, ALIGNING = 3200, 100
"""Default number of periods, and the periods before in which the variations align."""


@dataclass(frozen=True, repr=False)
class LyapunovSpectrum(Outlined):
    """The Lyapunov exponents of an orbit, the largest first, with their convergence.

    The exponent 0 of the phase of the force is not among them.

    Attributes
    ----------
    exponents : (4,) ndarray
        Mean growth rates [1/s]; two without a damper; -inf for variations that contacts reduce to
        zero.
    widths : (4,) ndarray
        Half widths of their 99 % intervals [1/s], from the means of 16 successive batches; 0 for
        exponents of -inf.
    times : (periods,) ndarray
        Times [s] at the ends of the periods, from the end of the `ALIGNING` periods.
    running : (periods, 4) ndarray
        Mean growth rates [1/s] up to these times; the last row is `exponents`.
    divergence : float
        Mean divergence [1/s] of the flow and the contacts, computed apart from the exponents. Their
        sum equals it: -(c1 + c2) / m1 - c2 / m2 if contacts dissipate nothing.
    """

    exponents: np.ndarray
    widths: np.ndarray
    times: np.ndarray
    running: np.ndarray
    divergence: float

    @property
    def dimension(self) -> float:
        """The dimension of the section by Kaplan and Yorke; that of the flow is greater by one.

        j + (sum of the first j exponents) / |exponent j + 1|, with the largest j whose sum is not
        negative.
        """
        sums = np.cumsum(self.exponents)
        j = int(np.count_nonzero(sums >= 0.0))
        if j in (0, len(sums)):
            return float(j)
        return j + float(sums[j - 1] / abs(self.exponents[j]))

    def outline(self) -> Rows:
        """Return the exponents with their intervals, and the check of their sum."""
        pairs = zip(self.exponents.tolist(), self.widths.tolist(), strict=True)
        yield "exponents [1/s]", "; ".join(f"{e:.4g} +- {width:.1g}" for e, width in pairs)
        total = float(self.exponents.sum())
        yield "sum [1/s]", f"{total:.10g}; mean divergence {self.divergence:.10g}"
        yield "averages over", f"{len(self.times)} forcing periods, {self.times[-1]:.6g} s"


def lyapunov_spectrum(
    system: System,
    start: Sequence[float] | np.ndarray | None,
    periods: int = PERIODS,
    quiet: bool = False,
) -> LyapunovSpectrum:
    """Return the Lyapunov spectrum of the orbit from `start` (x1, v1, x2, v2) over `periods`.

    The orbit is followed for `ALIGNING` periods before.  Raises `RequestError` for a wrong
    argument, `IntegrationError` if the integration fails.
    """
    whole("periods", periods, BATCHES)
    y = start_state(system, system.cell.rest, start)[:4]
    needed = Needed(system.scene.key, "exact", ())
    logs, volume = _growth(system, y, ALIGNING + periods, Compilation(needed, notice(quiet), False))
    times = system.period * np.arange(1, periods + 1)
    running = np.cumsum(logs[ALIGNING:], axis=0) / times[:, np.newaxis]
    each = periods // BATCHES
    batches = logs[-each * BATCHES :].reshape(BATCHES, each, -1).mean(axis=1) / system.period
    with np.errstate(invalid="ignore"):  # -inf, which has no width
        widths = QUANTILE * batches.std(axis=0, ddof=1) / math.sqrt(BATCHES)
    divergence = float(volume[ALIGNING:].sum()) / float(times[-1])
    return LyapunovSpectrum(running[-1], np.nan_to_num(widths), times, running, divergence)


@stoppable
def _growth(
    system: System, y: np.ndarray, periods: int, compilation: Compilation
) -> tuple[np.ndarray, np.ndarray]:
    """Return the logarithms of the growth of orthonormal variations and of volumes in each period.

    Shapes (periods, size) and (periods,).  Each component is scaled by the energy norm of its unit
    state.
    """
    parts, size = parts_of("exact", system.scene, Settings()), len(system.scene.components)
    cell = np.atleast_1d(system.cells()).view(np.recarray)
    traced = cycles.Traced(
        np.empty((1, 4)), np.zeros(2, np.int64), np.empty((size, size)), np.empty((0, 4)),
        np.empty((size, 2)), np.empty(cycles.NUMBERS_OF_CYCLE),
    )  # fmt: skip
    logs, volume, norms = np.empty((periods, size)), np.empty(periods), np.empty(size)
    with compilation.followed({cycles.trace: "branches", cycles.fill_norms: "branches"}):
        cycles.fill_norms(parts, cell[0], norms)
        norms[norms == 0.0] = 1.0  # a spring without stiffness has no energy
        vectors = np.eye(size)  # one row each
        for p in range(periods):
            status = cycles.trace(parts, cell, cell[:0], 0.0, y, traced)
            if status != OK:
                raise IntegrationError.of(system, status)
            y, volume[p] = traced.points[0].copy(), traced.numbers[cycles.LOG_DETERMINANT]
            scaled = traced.matrix * norms[:, np.newaxis] / norms
            images = (scaled * vectors[:, np.newaxis, :]).sum(axis=2)
            vectors, logs[p] = _orthonormalized(images)
    return logs, volume


def _orthonormalized(vectors: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return orthonormal rows by the Gram-Schmidt process, and the logarithms of their lengths.

    Every projection is done twice, which suffices for orthogonality to round-off.  A
    vector of length 0 stays 0.
    """
    result, lengths = np.zeros_like(vectors), np.zeros(len(vectors))
    for i, vector in enumerate(vectors):
        for _ in range(2):
            for other in result[:i]:
                vector = vector - (vector * other).sum() * other
        lengths[i] = math.sqrt(float((vector * vector).sum()))
        if lengths[i] > 0.0:
            result[i] = vector / lengths[i]
    with np.errstate(divide="ignore"):
        return result, np.log(lengths)
