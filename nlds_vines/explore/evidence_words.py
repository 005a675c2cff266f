"""A label and its evidence in words: what an orbit is, and how one knows."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from nlds_vines.orbits.classification import Regime


def words_of(regime: Regime) -> str:
    """Return what an orbit is, in one sentence."""
    if regime.kind == "periodic":
        return f"{_cycle(regime)} with {_impacts(regime)}"
    if regime.kind == "transient_chaos":
        return f"chaos that ended: now {_cycle(regime)} with {_impacts(regime)}"
    return {
        "quasiperiodic": "a motion on a torus",
        "chaotic": "neighbouring orbits part, for all the periods that were followed",
        "undetermined": "no test of a regime was met",
    }.get(regime.kind, regime.kind)


def evidence_of(regime: Regime) -> list[tuple[str, str]]:
    """Return the evidence, a (quantity, value in words) each; what does not apply is left out."""
    return list(_evidence(regime))


def _evidence(regime: Regime) -> Iterator[tuple[str, str]]:
    if regime.period:
        yield "repeats to", f"{regime.residual:.1e} (relative)"
        assert regime.multipliers is not None
        largest = float(np.abs(regime.multipliers[0]))
        stands = "stable" if largest < 1 else "unstable"
        yield "largest multiplier", f"|μ| = {largest:.4g}: {stands}"
    yield from _exponents(regime)
    if regime.settling >= 0:
        yield "settled after", f"{regime.settling} periods"
    if math.isfinite(regime.clearance):
        yield "nearest miss", f"{regime.clearance:.3g} m"
    if math.isfinite(regime.softest):
        yield "softest impact", f"{regime.softest:.3g} m/s"
    if not regime.period and math.isfinite(regime.averaging):
        yield "averages over time converge to", f"{regime.averaging:.1f} digits"
    yield "followed for", f"{regime.watched} periods"
    if math.isfinite(regime.least_lifetime):
        yield "if transient", f"a mean life of {regime.least_lifetime:.0f} periods at least (95 %)"


def _exponents(regime: Regime) -> Iterator[tuple[str, str]]:
    """Yield the largest exponent, with its interval where it is an estimate."""
    if not math.isfinite(regime.lyapunov):
        return
    width = f" ± {regime.lyapunov_width:.1g}" if regime.lyapunov_width else ""
    yield "exponent λ₁", f"{regime.lyapunov:.4g}{width} 1/s"
    if math.isfinite(regime.transient_lyapunov):
        width = f" ± {regime.transient_lyapunov_width:.1g}"
        yield "before it settled", f"{regime.transient_lyapunov:.4g}{width} 1/s"


def _cycle(regime: Regime) -> str:
    n = regime.period
    return "repeats every forcing period" if n == 1 else f"repeats every {n} forcing periods"


def _impacts(regime: Regime) -> str:
    k = regime.impacts
    return "no impact" if k == 0 else f"{k} impact{'s' * (k > 1)} in each"
