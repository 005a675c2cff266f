"""The style of pictures: sizes, fonts, colors, labels of axes; and plain text typeset in LaTeX.

Colors are those of Okabe and Ito, which color-blind readers distinguish.  Typeset, 2.5e+07 N/m^1.5
becomes 2.5 x 10^7 N/m^(3/2), and K is italic.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from fractions import Fraction
from types import MappingProxyType
from typing import Any

from nlds_vines.errors import MOST_CHARACTERS, printable
from nlds_vines.model.parameters import DESCRIBED, PHASE
from nlds_vines.model.quantities import BY_NAME, COORDINATES, STRUCTURE, clause
from nlds_vines.model.scenes import BODIES, MOVING
from nlds_vines.model.signals import SIGNALS

CM = 1 / 2.54  # one centimeter in inches
WIDTH = 16 * CM  # width in inches of a picture over two columns

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

GREEN = HUES["green"]  # the color of the structure's energy, green as in the paper
NAVY = "#1b2a49"
"""The color of a single curve, and of orbits from rest."""

GRAY = "#8a8a8a"
"""The color of thin lines that are no result: a zero, a hatch, a frame."""

NO_VALUE = "#c8c8c8"
"""The color of cells without a value."""

SHADES = "viridis"  # the color map of numbers, with even steps of lightness

DOT: dict[str, Any] = {"marker": "o", "markeredgewidth": 0, "linestyle": "none"}  # a cloud of dots
ROUND_OFF = 1e-17  # the value at which an error of zero is drawn; smaller values are round-off

_POLICIES = {"rest": NAVY, "up": HUES["blue"], "down": HUES["vermillion"]}
STARTS = (
    NAVY,
    *(HUES[name] for name in ("vermillion", "blue", "pink", "orange", "sky")),
    "#555555",
)
"""Colors of other starts; the first and the last are too dark for a dark page."""


def axis_label(parameter: str) -> str:
    entry = DESCRIBED[parameter]
    return labeled(entry.meaning.partition(";")[0], in_latex(entry.short_symbol), entry.unit)


def quantity_label(name: str, unit: str, long_name: str = "", body: str = STRUCTURE) -> str:
    """Return meaning, symbol and unit of a component of the state or of a recorded quantity.

    The owner in `roof.x_max`, or the signal in `broadband:x1`, stands behind the symbol. A quantity
    without a label in `model.quantities` is labeled by the first clause of its `long_name`. `body`
    is the word for the forced body.
    """
    part, _, name = name.rpartition(".")
    if not part:
        name, _, part = name.partition(":")
    meaning, symbol = COORDINATES.get(name, ("", ""))
    if name in BY_NAME:
        meaning, symbol = BY_NAME[name].label, BY_NAME[name].symbol
    meaning = (meaning or clause(long_name) or name).replace(STRUCTURE, body)
    if part:
        meaning, symbol = f"{labeled(meaning, in_latex(symbol), '1')}, {part}", ""
    return labeled(meaning, in_latex(symbol), unit)


def body_of(kind: object) -> str:
    """Return the word for the forced body of a kind of system, named as in archives."""
    return BODIES.get(str(kind).removesuffix(MOVING), STRUCTURE)


def start_colors(starts: Sequence[str]) -> list[str]:
    return [_POLICIES.get(name, STARTS[i % len(STARTS)]) for i, name in enumerate(starts)]


def labeled(meaning: str, symbol: str, unit: str) -> str:
    """Return a label, with a comma before the symbol if the meaning has commas."""
    if symbol and "," in meaning:
        meaning += ","
    parts = (meaning, f"${symbol}$" if symbol else "", f"[{raised(unit)}]" if unit != "1" else "")
    return " ".join(filter(None, parts))


_GREEK = {"ω": r"\omega", "ν": r"\nu", "ζ": r"\zeta", "φ": r"\varphi", "λ": r"\lambda"}
_LATEX = {**_GREEK, "₀": "_0", "₁": "_1", "₂": "_2"}
_SPECIAL = re.compile(r"[ _#%&{}]")  # of names within a formula
_EXTREME = re.compile("(max|peak)$")
_POWER = re.compile(r"(?<=[A-Za-z])\^(-?\d+(?:\.\d+)?)")
_SCIENTIFIC = re.compile(r"(?<![\w.])([-+]?\d+(?:\.\d+)?)e([-+]?\d+)(?![\w.])")
_PLAIN = (1e-3, 1e4)  # bounds of numbers without a power of ten


def latex_symbol(parameter: str) -> str:
    return in_latex(DESCRIBED[parameter].symbol)


def in_latex(symbol: str) -> str:
    """Return a symbol such as ω, E₁max or z_min in LaTeX, as fonts lack the Unicode subscripts.

    That of a host's parameter, `gap+ of cell`, has its wall above and its owner below.
    """
    key, of, owner = symbol.partition(" of ")
    if of:
        letters, side = key.rstrip("+-"), key[len(key.rstrip("+-")) :]
        head = f"{{{in_latex(letters)}}}" if len(letters) < 3 else rf"\mathrm{{{letters}}}"
        below = _SPECIAL.sub(r"\\\g<0>", owner)
        return head + (f"^{{{side}}}" if side else "") + rf"_{{\mathrm{{{below}}}}}"
    text = "".join(_LATEX.get(letter, letter) for letter in symbol)
    text = _EXTREME.sub(lambda match: rf"^{{\,\mathrm{{{match[1]}}}}}", text)
    return text.replace("_min", r"_\mathrm{min}")


def power_of_ten(text: str) -> str:
    """Return a number in LaTeX: 2.5e+07 becomes 2.5 x 10^7."""
    match = _SCIENTIFIC.fullmatch(text)
    if match is None:
        return text
    factor = "" if match[1] == "1" else rf"{match[1]}\times"
    return rf"{factor}10^{{{int(match[2])}}}"


def number_text(value: float) -> str:
    """Return a number of up to six digits in LaTeX: 3.95 x 10^4, 0.05."""
    if not value or _PLAIN[0] <= abs(value) < _PLAIN[1]:
        return f"{value:g}"
    digits, _, power = f"{value:.6e}".partition("e")
    return power_of_ten(f"{float(digits):g}e{power}")


def raised(unit: str) -> str:
    return _POWER.sub(lambda match: f"$^{{{_fraction(match[1])}}}$", unit)


def setting_label(parameter: str, value: float) -> str:
    unit = DESCRIBED[parameter].unit
    text = f"${latex_symbol(parameter)}={number_text(value)}$"
    return text + (f" {raised(unit)}" if unit != "1" else "")


def literal(text: str) -> str:
    """Return a text of a request, shortened and escaped, so that matplotlib draws no formula."""
    return printable(text[:MOST_CHARACTERS]).replace("$", r"\$")


def typeset(text: str) -> str:
    """Return a text of a request with typeset symbols, powers of ten and units.

    A symbol of one ASCII letter counts only before " = ", " from " and " tuned ", and in a list at
    the start or after ": " that runs to the end, " from " or " tuned ": `P = 600 N`, `map: ω, C`,
    but not the P of a name.
    """
    printed = _POWER.sub(lambda m: f"$^{{{_fraction(m[1])}}}$", literal(text))
    printed = _SCIENTIFIC.sub(lambda m: f"${power_of_ten(m[0])}$", printed)
    printed = _LIST.sub(lambda m: ", ".join(map(_in_latex, m[0].split(", "))), printed)
    return _SYMBOL.sub(lambda m: _in_latex(m[0]), printed)


def _in_latex(text: str) -> str:
    return f"${latex_symbol(_NAMES[text])}$"


def _fraction(power: str) -> str:
    """Return a power, a half as a fraction: 3/2 for 1.5."""
    fraction = Fraction(power)
    return str(fraction) if fraction.denominator <= 2 else power


_IN_WORDS = ("exponent", "hunt_crossley")  # names that titles spell out
_NAMES = {
    text: name
    for name, entry in DESCRIBED.items()
    if name not in _IN_WORDS
    for text in (name, entry.symbol)
    if text != PHASE  # a word of many titles
}
_LONGEST_FIRST = sorted(_NAMES, key=len, reverse=True)
_SYMBOL = re.compile(
    "|".join(
        rf"(?<![\w$\\]){re.escape(text)}(?![\w'^])"
        + ("(?= (?:=|from|tuned) )" if len(text) == 1 and text.isascii() else "")
        for text in _LONGEST_FIRST
    )
)
_ANY = "|".join(map(re.escape, _LONGEST_FIRST))
_LIST = re.compile(rf"(?:(?<=: )(?:{_ANY})|^(?:{_ANY})(?=, ))(?:, (?:{_ANY}))*(?=$| from | tuned )")


def signal_symbol(signal: str) -> str:
    """Return a signal in LaTeX: x1, v1 as x1 with a dot, u as x2 - x1; of a host its name."""
    if signal == "u":
        return "$x_2-x_1$"
    if signal not in SIGNALS:
        return signal
    letter, number = signal[0], signal[1:]
    symbol = letter if letter == "x" else r"\dot{x}"
    return f"${symbol}_{number}$" if number else f"${symbol}$"
