"""How pictures look: made for print, 16 cm wide, 8 to 9 pt, the paper's symbols, units on all axes.

Colours are those of Okabe and Ito, which colour-blind readers tell apart.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import Any

from nlds_vines.model.parameters import PARAMETERS

CM = 1 / 2.54
"""One centimetre in inches."""

WIDTH = 16 * CM
"""Width of every picture in inches."""

LEFT, RIGHT = 0.095, 0.905
"""The sides of the panels as fractions of the width: fixed, so that text can be placed undrawn."""

STYLE: dict[Any, Any] = {
    "font.family": "STIXGeneral",
    "mathtext.fontset": "stix",
    "font.size": 9,
    "axes.labelsize": 9,
    "axes.linewidth": 0.6,
    "xtick.labelsize": 8,
    "ytick.labelsize": 8,
    "xtick.direction": "in",
    "ytick.direction": "in",
    "legend.fontsize": 8,
    "hatch.linewidth": 0.4,
    "pdf.fonttype": 42,
}
"""Settings of matplotlib under which pictures are made and saved."""

GREEN = "#009e73"
"""The structure's energy, green as in the paper."""

ERRORS = ("error", "error_at_end", "E1max_error")
"""What is drawn by logarithm."""

ROUND_OFF = 1e-17
"""Where an error of zero is drawn: what is below says nothing."""

FLAGGED = "label changes under refinement"
"""What a mark says of an orbit whose label is not kept."""

FLAG_COLOUR = "#c00000"
"""The colour of such marks."""

_POLICIES = {"rest": "#1b2a49", "up": "#0072b2", "down": "#d55e00"}
_STARTS = ("#1b2a49", "#d55e00", "#0072b2", "#cc79a7", "#e69f00", "#56b4e9", "#555555")

_QUANTITIES = {
    "x1": ("structure", "x_1"),
    "x2": ("damper", "x_2"),
    "reduction": ("reduction by the damper", ""),
    "E1max": ("energy of the structure", r"E_1^{\,\mathrm{max}}"),
    "E2max": ("energy of the damper", r"E_2^{\,\mathrm{max}}"),
    "impact_rate": ("impacts per forcing period", ""),
    "clearance": ("smallest near miss", r"z_\mathrm{min}"),
    "period": ("period", "n"),
    "E1peak": ("energy of the structure", r"E_1^{\,\mathrm{peak}}"),
    "E2peak": ("energy of the damper", r"E_2^{\,\mathrm{peak}}"),
    "settling": ("forcing periods until settled", ""),
    "lyapunov": ("Lyapunov exponent", r"\lambda_1"),
    "transient_lyapunov": ("exponent before settling", r"\lambda_1"),
    "violation_depth": ("deepest violation", ""),
    "error": ("error over a period", ""),
    "error_at_end": ("difference from a refined run", ""),
    "E1max_error": ("difference from a refined run", r"E_1^{\,\mathrm{max}}"),
}
_LATEX = {"ω": r"\omega", "ν": r"\nu", "₁": "_1", "₂": "_2"}


def axis_label(parameter: str) -> str:
    """Return meaning, symbol and unit of a varied parameter: what stands along its axis."""
    entry = PARAMETERS[parameter]
    return _labelled(entry.meaning, latex_symbol(parameter), entry.unit)


def latex_symbol(parameter: str) -> str:
    """Return the symbol of a parameter as mathematics: the fonts lack the plain subscripts."""
    return "".join(_LATEX.get(letter, letter) for letter in PARAMETERS[parameter].symbol)


def quantity_label(name: str, unit: str) -> str:
    """Return meaning, symbol and unit of a component of the state or of a recorded number."""
    return _labelled(*_QUANTITIES[name], unit)


def setting_label(parameter: str, value: float) -> str:
    """Return symbol, value and unit of a parameter that is set, as mathematics: k1 = 3.95e4 N/m."""
    entry = PARAMETERS[parameter]
    symbol = "".join(_LATEX.get(letter, letter) for letter in entry.symbol)
    digits, _, power = f"{value:.6e}".partition("e")
    shown = f"{value:g}"
    if not 1e-3 <= abs(value) < 1e4 and value:
        shown = rf"{float(digits):g}\cdot10^{{{int(power)}}}"
    unit = f" {entry.unit}" if entry.unit != "1" else ""
    return f"${symbol}={shown}${unit}"


def start_colours(starts: Sequence[str]) -> list[str]:
    """Return a colour for every start; there are seven, which then come again."""
    return [_POLICIES.get(name, _STARTS[i % len(_STARTS)]) for i, name in enumerate(starts)]


def _labelled(meaning: str, symbol: str, unit: str) -> str:
    parts = (meaning, f"${symbol}$" if symbol else "", f"[{_raised(unit)}]" if unit != "1" else "")
    return " ".join(filter(None, parts))


def _raised(unit: str) -> str:
    """Return a unit with its powers raised: N/m^1.5."""
    return re.sub(r"\^([-\d.]+)", r"$^{\1}$", unit)
