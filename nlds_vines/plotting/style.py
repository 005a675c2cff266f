"""The style of pictures: sizes and fonts for print, colors, labels of axes with symbol and unit.

Colors are those of Okabe and Ito, which color-blind readers distinguish.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from types import MappingProxyType
from typing import Any

from nlds_vines.model.parameters import described
from nlds_vines.model.quantities import BY_NAME, COORDINATES, STRUCTURE, clause
from nlds_vines.model.scenes import FOOT, SCENES
from nlds_vines.plotting.notation import in_latex, latex_symbol, raised

CM = 1 / 2.54
"""One centimeter in inches."""

WIDTH = 16 * CM
"""Width of every picture in inches."""

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
"""Settings of matplotlib for pictures."""

HUES: Mapping[str, str] = MappingProxyType(
    {
        "black": "#000000",
        "gray": "#767676",
        "orange": "#e69f00",
        "sky": "#56b4e9",
        "green": "#009e73",
        "blue": "#0072b2",
        "vermillion": "#d55e00",
        "pink": "#cc79a7",
    }
)
"""Colors of Okabe and Ito, with gray and without yellow, which is too pale for a line."""

GREEN = HUES["green"]
"""The color of the structure's energy, green as in the paper."""

NAVY = "#1b2a49"
"""The color of a single curve, and of orbits from rest."""

GRAY = "#8a8a8a"
"""The color of thin lines that are no result: a zero, a hatch, a frame."""

NO_VALUE = "#c8c8c8"
"""The color of cells without a value."""

SHADES = "viridis"
"""The color map of numbers, with even steps of lightness."""

DOT: dict[str, Any] = {"marker": "o", "markeredgewidth": 0, "linestyle": "none"}
"""Settings of a cloud of dots, without their size."""

ROUND_OFF = 1e-17
"""The value at which an error of zero is drawn; smaller values are round-off."""

_POLICIES = {"rest": NAVY, "up": HUES["blue"], "down": HUES["vermillion"]}
STARTS = (
    NAVY,
    *(HUES[name] for name in ("vermillion", "blue", "pink", "orange", "sky")),
    "#555555",
)
"""Colors of starts that have none in the palette. The last one is too dark for a dark page."""


def axis_label(parameter: str) -> str:
    """Return the label of the axis of a parameter: meaning up to a semicolon, symbol, unit."""
    entry = described(parameter)
    return labeled(entry.meaning.partition(";")[0], latex_symbol(parameter), entry.unit)


def quantity_label(name: str, unit: str, long_name: str = "", body: str = STRUCTURE) -> str:
    """Return meaning, symbol and unit of a component of the state or of a recorded quantity.

    A quantity without a label in `model.quantities` is labeled by the first clause of its
    `long_name`.  `body` is the word for the forced body.
    """
    meaning, symbol = COORDINATES.get(name, ("", ""))
    if name in BY_NAME:
        meaning, symbol = BY_NAME[name].label, BY_NAME[name].symbol
    meaning = (meaning or clause(long_name) or name).replace(STRUCTURE, body)
    return labeled(meaning, in_latex(symbol), unit)


def body_of(kind: object) -> str:
    """Return the word for the forced body of a kind of system, named as in archives."""
    scene = SCENES.get(str(kind).removesuffix(FOOT))
    return STRUCTURE if scene is None else scene.body


def start_colors(starts: Sequence[str]) -> list[str]:
    """Return a color for every start, by its name; others repeat after seven."""
    return [_POLICIES.get(name, STARTS[i % len(STARTS)]) for i, name in enumerate(starts)]


def labeled(meaning: str, symbol: str, unit: str) -> str:
    """Return a label; without a symbol if it is empty, without a unit if it is 1.

    A comma separates the symbol from a meaning with commas.
    """
    if symbol and "," in meaning:
        meaning += ","
    parts = (meaning, f"${symbol}$" if symbol else "", f"[{raised(unit)}]" if unit != "1" else "")
    return " ".join(filter(None, parts))
