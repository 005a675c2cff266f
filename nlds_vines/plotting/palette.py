"""Colours of regimes: one ordered ramp for the period, a tint for the impacts, dark for chaos.

The ramp follows viridis and grows lighter with the period; the single hues are near those of Okabe
and Ito.  Colour-blind readers tell them apart, and the ramp keeps its order in a grey print.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from math import inf
from typing import Any

from nlds_vines.orbits.coexistence import final
from nlds_vines.orbits.labels import TRANSIENT
from nlds_vines.plotting.style import GREY, HUES, NO_VALUE

RAMP = ("#4a6fae", "#2a929a", "#35b779", "#7ad151", "#bddf26", "#fde725")
"""Colours of T, 2T, 3T, 4T, 5T, and of 6T and longer."""

OTHERS: Mapping[str, str] = {
    "quasiperiodic": HUES["pink"],
    "chaos": "#1a1a1a",
    "transient chaos": "#5a2d0c",
    "undetermined": NO_VALUE,
    "failed": "#d7191c",
}
"""Colours of regimes that are not periodic.

That of a transient is mixed into the colour of the regime in which it ends."""

HATCHED = "undetermined"
"""The label that is drawn with a hatch beside its colour: a gap in knowledge looks like a gap."""

_PERIODIC = re.compile(r"(\d*)T(?:,(\d+))?")
_MOST_WHITE = 0.62  # share of white in the colour of a regime without impacts
_BROWN = 0.6  # share of the transients' brown in the colour of a regime reached through chaos
_DARK = 140.0  # luma, of 255, below which writing is white


def period_and_impacts(label: str) -> tuple[int, int] | None:
    """Return n and k of a label `nT,k`; None for any other regime."""
    match = _PERIODIC.fullmatch(label)
    return (int(match[1] or 1), int(match[2] or 0)) if match else None


def short(label: str) -> str:
    """Return a label as pictures write it: `transient chaos to T,0` becomes `chaos → T,0`."""
    return label.replace(TRANSIENT, "chaos → ")


def ordered(labels: Iterable[str]) -> list[str]:
    """Return the different labels by period and impacts, then those that are not periodic."""

    def place(label: str) -> tuple[float, float, str]:
        periodic = period_and_impacts(label)
        return (*periodic, label) if periodic else (inf, list(OTHERS).index(_kind(label)), label)

    return sorted(set(labels), key=place)


def colours(labels: Iterable[str]) -> dict[str, str]:
    """Return a colour, as `#rrggbb`, for every label.

    The period n takes its colour from the ramp.  Of equal n, the regime with the most impacts has
    the plain colour and one without impacts the palest, so that T,0 and T,1 always differ.  A
    regime that was reached through chaos is darkened by brown: similar to the regime itself, and
    not equal.
    """
    labels = set(labels)
    plain = _plain_colours({final(label) for label in labels})
    return {
        label: _mixed(plain[final(label)], OTHERS["transient chaos"], _BROWN)
        if label.startswith(TRANSIENT)
        else plain[label]
        for label in labels
    }


def patch_look(label: str, colour: str) -> dict[str, Any]:
    """Return how a patch of a regime is filled: its colour without a line, or a hatch over it."""
    look: dict[str, Any] = {"facecolor": colour, "linewidth": 0}
    return look | ({"hatch": "//////", "edgecolor": GREY} if label == HATCHED else {})


def is_dark(colour: str) -> bool:
    """Return whether writing on this colour is to be white.

    By the luma of ITU-R BT.601, 0.299 R + 0.587 G + 0.114 B, of channels from 0 to 255.
    """
    red, green, blue = _channels(colour)
    return 0.299 * red + 0.587 * green + 0.114 * blue < _DARK


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


def _kind(label: str) -> str:
    """Return the key of `OTHERS` under which a label that is not periodic stands."""
    return next((kind for kind in OTHERS if label.startswith(kind)), "undetermined")


def _tinted(n: int, k: int, most: int) -> str:
    """Return the colour of nT,k where the most impacts of any nT are `most`."""
    return _mixed(RAMP[min(n, len(RAMP)) - 1], "#ffffff", _MOST_WHITE * (1 - k / most))


def _mixed(colour: str, other: str, share: float) -> str:
    """Return a colour with a share, from 0 to 1, of another one mixed in."""
    pairs = zip(_channels(colour), _channels(other), strict=True)
    return "#" + "".join(f"{round(c + (o - c) * share):02x}" for c, o in pairs)


def _channels(colour: str) -> tuple[int, int, int]:
    """Return red, green and blue of `#rrggbb`, from 0 to 255."""
    red, green, blue = (int(colour[i : i + 2], 16) for i in (1, 3, 5))
    return red, green, blue
