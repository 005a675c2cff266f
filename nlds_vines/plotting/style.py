"""How pictures look: made for print, 16 cm wide, 8 to 9 pt, the paper's symbols, units on all axes.

Colours are those of Okabe and Ito, which colour-blind readers tell apart.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from types import MappingProxyType
from typing import Any

from nlds_vines.model.parameters import described
from nlds_vines.model.scenes import SCENES
from nlds_vines.model.scenes.base import FOOT
from nlds_vines.plotting.notation import latex_symbol, raised

CM = 1 / 2.54
"""One centimetre in inches."""

WIDTH = 16 * CM
"""Width of every picture in inches."""

LEFT, RIGHT = 0.095, 0.905
"""The sides of the panels as fractions of the width.

They are fixed, so that names can be placed before anything is drawn."""

STYLE: dict[Any, Any] = {
    "font.family": ["STIXGeneral", "DejaVu Sans"],  # the second has the subscripts of m₁ and ω₁
    "mathtext.fontset": "stix",
    "font.size": 9,
    "axes.labelsize": 9,
    "axes.linewidth": 0.6,
    "axes.formatter.use_mathtext": True,
    "axes.formatter.limits": (-5, 5),
    "xtick.labelsize": 8,
    "ytick.labelsize": 8,
    "xtick.direction": "in",
    "ytick.direction": "in",
    "legend.fontsize": 8,
    "legend.frameon": False,
    "hatch.linewidth": 0.4,
    "pdf.fonttype": 42,
}
"""Settings of matplotlib under which pictures are made and saved."""

HUES: Mapping[str, str] = MappingProxyType(
    {
        "black": "#000000",
        "grey": "#767676",
        "orange": "#e69f00",
        "sky": "#56b4e9",
        "green": "#009e73",
        "blue": "#0072b2",
        "vermillion": "#d55e00",
        "pink": "#cc79a7",
    }
)
"""Colours by name: those of Okabe and Ito, and grey; without yellow, too pale for a line."""

GREEN = HUES["green"]
"""The colour of the structure's energy, green as in the paper."""

NAVY = "#1b2a49"
"""The colour of a curve that stands alone, and of orbits from rest."""

GREY = "#8a8a8a"
"""The colour of thin lines that are no result: a zero, a hatch, the frame of a patch."""

NO_VALUE = "#c8c8c8"
"""The colour of cells without a value."""

SHADES = "viridis"
"""The colour map of numbers: even steps of lightness, in colour-blind sight and grey print too."""

DOT: dict[str, Any] = {"marker": "o", "markeredgewidth": 0, "linestyle": "none"}
"""Settings of a cloud of unconnected dots; their size is the picture's."""

ERRORS = ("error", "error_at_end", "E1max_error", "broadband", "line_amplitude")
"""The recorded numbers that are drawn on a logarithmic scale."""

ROUND_OFF = 1e-17
"""The value at which one of them that is zero is drawn: smaller ones are round-off."""

FLAGGED = "label changes under refinement"
"""What a legend says of the marks of orbits whose label is not kept."""

FLAG_COLOUR = "#c00000"
"""The colour of such marks."""

STRUCTURE = "structure"
"""The word for the body that is forced; kinds of one mass have another (`Scene.body`)."""

_POLICIES = {"rest": NAVY, "up": HUES["blue"], "down": HUES["vermillion"]}
_STARTS = (
    NAVY,
    *(HUES[name] for name in ("vermillion", "blue", "pink", "orange", "sky")),
    "#555555",
)

_QUANTITIES = {
    "x": ("structure", "x"),
    "x1": ("structure", "x_1"),
    "x2": ("damper", "x_2"),
    "v": ("velocity", "v"),
    "v1": ("velocity of the structure", "v_1"),
    "v2": ("velocity of the damper", "v_2"),
    "softest_impact": ("smallest approach speed", ""),
    "impact_speed": ("approach speed", ""),
    "impacts": ("impacts per $n$T", ""),
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
    "transmissibility": ("transmissibility", ""),
    "power_c1": ("dissipated power", "c_1"),
    "power_c2": ("dissipated power", "c_2"),
    "power_contact": ("dissipated by contacts", ""),
    "power_in": ("power put in", ""),
    "broadband": ("broadband share", ""),
    "line_amplitude": ("amplitudes of lines", ""),
}
_MOTIONS = {
    "x1": "displacement",
    "v1": "velocity",
    "a1": "acceleration",
    "stroke": "stroke",
    "foot": "displacement from the foot",
    "force": "contact force",
    "impulse": "impulse",
}
for _name, _motion in _MOTIONS.items():
    _QUANTITIES[f"{_name}_max"] = f"largest {_motion}", ""
    _QUANTITIES[f"{_name}_rms"] = f"rms {_motion}", ""
    _QUANTITIES[f"{_name}_max_reduction"] = f"reduction, largest {_motion}", ""
    _QUANTITIES[f"{_name}_rms_reduction"] = f"reduction, rms {_motion}", ""
_LONGEST = 48  # characters of a label along an axis


def axis_label(parameter: str) -> str:
    """Return what stands along the axis of a varied parameter: meaning, symbol and unit.

    What follows a semicolon in the meaning explains values, and is no name of the axis.
    """
    entry = described(parameter)
    return _labelled(entry.meaning.partition(";")[0], latex_symbol(parameter), entry.unit)


def quantity_label(name: str, unit: str, long_name: str = "", body: str = STRUCTURE) -> str:
    """Return meaning, symbol and unit of a component of the state or of a recorded number.

    One that has no label of its own here is labelled by the beginning of its `long_name`.  `body`
    is the word for the body that is forced.
    """
    meaning, symbol = _QUANTITIES.get(name, (_clause(long_name) or name, ""))
    meaning = meaning.replace(STRUCTURE, body)
    return _labelled(meaning, symbol, unit)


def body_of(kind: object) -> str:
    """Return the word for the body that is forced in systems of a kind, as archives name it."""
    scene = SCENES.get(str(kind).removesuffix(FOOT))
    return STRUCTURE if scene is None else scene.body


def start_colours(starts: Sequence[str]) -> list[str]:
    """Return a colour for every start, by its name; after seven the colours repeat."""
    return [_POLICIES.get(name, _STARTS[i % len(_STARTS)]) for i, name in enumerate(starts)]


def _labelled(meaning: str, symbol: str, unit: str) -> str:
    """Return what stands along an axis; without a symbol or a unit where there is none."""
    parts = (meaning, f"${symbol}$" if symbol else "", f"[{raised(unit)}]" if unit != "1" else "")
    return " ".join(filter(None, parts))


def _clause(text: str) -> str:
    """Return what a text says before its first comma, semicolon or bracket, up to 48 characters."""
    clause = re.split(r"[,;:(]", text, maxsplit=1)[0].strip()
    return clause if len(clause) <= _LONGEST else clause[:_LONGEST].rpartition(" ")[0]
