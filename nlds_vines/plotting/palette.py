"""Colours of regimes: one ordered ramp for the period, a tint for the impacts, dark for chaos.

The ramp follows viridis and grows lighter with the period; the single hues are near those of Okabe
and Ito.  Colour-blind readers tell them apart, and the ramp is ordered in a grey print too.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from math import inf

RAMP = ("#4a6fae", "#2a929a", "#35b779", "#7ad151", "#bddf26", "#fde725")
"""Colours of T, 2T, 3T, 4T, 5T, and of 6T and longer."""

OTHERS: Mapping[str, str] = {
    "quasiperiodic": "#cc79a7",
    "chaos": "#1a1a1a",
    "transient chaos": "#5a2d0c",
    "undetermined": "#c8c8c8",
    "failed": "#d7191c",
}
"""Colours of what is not periodic; that of a transient is mixed into the one of what it ends in."""

HATCHED = "undetermined"
"""What is drawn with a hatch beside its colour: a gap in knowledge should look like one."""

TRANSIENT = "transient chaos to "
"""How a label begins whose orbit settled late; the rest of it is the final regime."""

_PERIODIC = re.compile(r"(\d*)T(?:,(\d+))?")
_PALEST = 0.62  # of white, for the fewest impacts
_PASSED = 0.6  # of the transients' brown, for what was reached through chaos


def period_and_impacts(label: str) -> tuple[int, int] | None:
    """Return n and k of a label `nT,k`; None for any other regime."""
    match = _PERIODIC.fullmatch(label)
    return (int(match[1] or 1), int(match[2] or 0)) if match else None


def short(label: str) -> str:
    """Return a label as pictures write it, a transient in short."""
    return label.replace(TRANSIENT, "chaos → ")


def ordered(labels: Iterable[str]) -> list[str]:
    """Return the different labels by period and impacts, and after them what is not periodic."""

    def place(label: str) -> tuple[float, float, str]:
        periodic = period_and_impacts(label)
        return (*periodic, label) if periodic else (inf, list(OTHERS).index(_kind(label)), label)

    return sorted(set(labels), key=place)


def colours(labels: Iterable[str]) -> dict[str, str]:
    """Return a colour, as a hex string, for every label.

    The period n takes its colour from the ramp; of equal n, the regime with the most impacts is
    plain and one without impacts palest, so that T,0 never looks like T,1.  What was reached
    through chaos is darkened by brown: kin to its final regime, and not the same.
    """
    labels = set(labels)
    ends = {label.removeprefix(TRANSIENT) for label in labels}
    plain, brown = _plain_colours(ends), OTHERS["transient chaos"]
    return {
        label: _mixed(plain[label.removeprefix(TRANSIENT)], brown, _PASSED)
        if label.startswith(TRANSIENT)
        else plain[label]
        for label in labels
    }


def _plain_colours(labels: Iterable[str]) -> dict[str, str]:
    """Return the colours of final regimes."""
    found = {label: period_and_impacts(label) for label in labels}
    most: dict[int, int] = {}
    for n, k in filter(None, found.values()):
        most[n] = max(k, most.get(n, 1))
    return {
        label: _tinted(*periodic, most[periodic[0]]) if periodic else OTHERS[_kind(label)]
        for label, periodic in found.items()
    }


def is_dark(colour: str) -> bool:
    """Tell whether writing on this colour should be white."""
    red, green, blue = _channels(colour)
    return 0.299 * red + 0.587 * green + 0.114 * blue < 140


def _kind(label: str) -> str:
    return next((kind for kind in OTHERS if label.startswith(kind)), "undetermined")


def _tinted(n: int, k: int, most: int) -> str:
    return _mixed(RAMP[min(n, len(RAMP)) - 1], "#ffffff", _PALEST * (1 - k / most))


def _mixed(colour: str, other: str, share: float) -> str:
    """Return a colour with a share, from 0 to 1, of another one mixed in."""
    pairs = zip(_channels(colour), _channels(other), strict=True)
    return "#" + "".join(f"{round(c + (o - c) * share):02x}" for c, o in pairs)


def _channels(colour: str) -> tuple[int, int, int]:
    red, green, blue = (int(colour[i : i + 2], 16) for i in (1, 3, 5))
    return red, green, blue
