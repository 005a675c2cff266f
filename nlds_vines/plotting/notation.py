"""Plain text typeset for pictures: 2.5e+07 N/m^1.5 becomes 2.5 x 10^7 N/m^(3/2), K is italic."""

from __future__ import annotations

import re
from fractions import Fraction

from nlds_vines.errors import MOST_CHARACTERS, printable
from nlds_vines.model.parameters import DESCRIBED, PHASE, described

_GREEK = {"ω": r"\omega", "ν": r"\nu", "ζ": r"\zeta", "φ": r"\varphi", "λ": r"\lambda"}
_LATEX = {**_GREEK, "₀": "_0", "₁": "_1", "₂": "_2"}
_EXTREME = re.compile("(max|peak)$")
_POWER = re.compile(r"(?<=[A-Za-z])\^(-?\d+(?:\.\d+)?)")
_SCIENTIFIC = re.compile(r"(?<![\w.])([-+]?\d+(?:\.\d+)?)e([-+]?\d+)(?![\w.])")
_PLAIN = (1e-3, 1e4)  # bounds of numbers without a power of ten


def latex_symbol(parameter: str) -> str:
    """Return the symbol of a parameter in LaTeX."""
    return in_latex(described(parameter).symbol)


def in_latex(symbol: str) -> str:
    """Return a symbol such as ω, E₁max or z_min in LaTeX, as fonts lack the Unicode subscripts."""
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
    """Return a number of up to seven digits in LaTeX: 3.95 x 10^4, 0.05."""
    if not value or _PLAIN[0] <= abs(value) < _PLAIN[1]:
        return f"{value:g}"
    digits, _, power = f"{value:.6e}".partition("e")
    return power_of_ten(f"{float(digits):g}e{power}")


def raised(unit: str) -> str:
    """Return a unit with superscripts: N/m^(3/2)."""
    return _POWER.sub(lambda match: f"$^{{{_fraction(match[1])}}}$", unit)


def setting_label(parameter: str, value: float) -> str:
    """Return symbol, value and unit of a parameter in LaTeX: k1 = 3.95 x 10^4 N/m."""
    unit = described(parameter).unit
    text = f"${latex_symbol(parameter)}={number_text(value)}$"
    return text + (f" {raised(unit)}" if unit != "1" else "")


def literal(text: str) -> str:
    """Return a text of a request, shortened and escaped, so that matplotlib draws no formula."""
    return printable(text[:MOST_CHARACTERS]).replace("$", r"\$")


def typeset(text: str) -> str:
    """Return a text of a request with typeset symbols, powers of ten and units.

    A symbol of one letter counts only before " = ", " from " and " tuned ", and in a list of
    symbols that ends a title or a clause: `P = 600 N`, `map: ω, C`, but not the P of a name.
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


def _pattern(text: str) -> str:
    alone = "(?= (?:=|from|tuned) )" if len(text) == 1 and text.isascii() else ""
    return rf"(?<![\w$\\]){re.escape(text)}(?![\w'^]){alone}"


_IN_WORDS = ("exponent", "hunt_crossley")  # names that titles spell out
_NAMES = {
    text: name
    for name, entry in DESCRIBED.items()
    if name not in _IN_WORDS
    for text in (name, entry.symbol)
    if text != PHASE  # a word of many titles
}
_SYMBOL = re.compile("|".join(map(_pattern, sorted(_NAMES, key=len, reverse=True))))
_ANY = "|".join(re.escape(text) for text in sorted(_NAMES, key=len, reverse=True))
_LIST = re.compile(rf"(?:(?<=: )(?:{_ANY})|^(?:{_ANY})(?=, ))(?:, (?:{_ANY}))*(?=$| from | tuned )")


def signal_symbol(signal: str) -> str:
    """Return a signal in LaTeX: x1, v1 as x1 with a dot, u as x2 - x1."""
    if signal == "u":
        return "$x_2-x_1$"
    letter, number = signal[0], signal[1:]
    symbol = letter if letter == "x" else r"\dot{x}"
    return f"${symbol}_{number}$" if number else f"${symbol}$"
