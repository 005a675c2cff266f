"""The colors of regimes and of dampers, the same in every picture, page and run.

The ramp of periods is near viridis and grows lighter, so that it keeps its order in gray print.
Color-blind readers distinguish periods from each other and from all other regimes:
`tests/plotting/test_palette.py` measures the distances in CIELAB.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from math import inf, sqrt
from typing import Any

from nlds_vines.model.labels import TRANSIENT, final
from nlds_vines.plotting.style import GRAY, HUES

RAMP = ("#44559f", "#1c7f9b", "#3fb769", "#88cb52", "#b4ee24", "#fff06e")
"""Colors of T, 2T, 3T, 4T, 5T, and of 6T and longer."""

OTHERS: Mapping[str, str] = {
    "quasiperiodic": "#861657",
    "chaos": "#1a1a1a",
    "transient chaos": "#5a2d0c",
    "undetermined": "#efefef",
    "failed": "#d7191c",
}
"""Colors of regimes that are not periodic."""

DAMPERS: Mapping[str, str] = {
    "none": HUES["gray"],
    "tmd": HUES["blue"],
    "ssbl": HUES["green"],
    "ssul-set1": HUES["black"],
    "ssul-set2": HUES["orange"],
    "ssul-set3": HUES["sky"],
    "ssul-set4": HUES["pink"],
    "ssul-set5": "#8c564b",
    "ssul-set6": HUES["vermillion"],
}
"""Colors of dampers by the names of their systems, those of the paper's figures."""

LONG = f"{len(RAMP)}T and longer"  # the name of the regimes that share the ramp's last color
_EXAMPLE = f"{len(RAMP)}T,1"  # one of these regimes
COUNTS = ("#f1efe9", "#f6c667", "#e07b39", "#a8324a", "#5b1a4a")
"""Colors of one, two, three ... regimes in a cell; the last one counts for more."""

HATCHED = "undetermined"  # the label with a hatch over its color

THROUGH_CHAOS = "...."  # the hatch over a regime reached through transient chaos
INADMISSIBLE = ", inadmissible"  # ends the label of an orbit that passes the limit of its scene
PASSED = "\\\\\\\\"  # the hatch over such orbits

_HATCHES = {HATCHED: "//////"}
_PERIODIC = re.compile(r"([1-9][0-9]{0,8})?T(?:,([0-9]{1,9})(?: \([0-9]+(?:\+[0-9]+)+\))?)?")
_MOST_WHITE = 0.53  # share of white in the color of a regime without impacts
_MOST_BLACK = 0.34  # share of black in that of a regime with ever more impacts
_DARKER = 0.3  # share of black in the color of a regime that was reached through chaos
_DARK = 140.0  # luma, of 255, below which writing is white
_INK = 150.0  # luma that the color of a dot on white paper has at most


def period_and_impacts(label: str) -> tuple[int, int] | None:
    """Return n and k of a label `nT,k` or `nT,k (k1+k2)`; None for any other regime."""
    match = _PERIODIC.fullmatch(label)
    return (int(match[1] or 1), int(match[2] or 0)) if match else None


def short(label: str) -> str:
    """Return a label as pictures write it: `transient chaos to T,0` becomes `chaos → T,0`."""
    return label.replace(TRANSIENT, "chaos → ")


def ordered(labels: Iterable[str]) -> list[str]:
    """Return the distinct labels by period and impacts, then those that are not periodic."""

    def place(label: str) -> tuple[float, float, str]:
        periodic = period_and_impacts(label.removesuffix(INADMISSIBLE))
        return (*periodic, label) if periodic else (inf, list(OTHERS).index(_kind(label)), label)

    return sorted(set(labels), key=place)


def color_of(label: str) -> str:
    """Return the color of a label, `#rrggbb`, which depends on nothing else.

    The period n sets the color of the ramp, n >= 6 the last one.  For smaller n, nT,n has the plain
    color; fewer impacts make it paler, more darker, the first of them most.  A regime reached
    through chaos is darker, and pictures hatch it (`patch_look`).
    """
    label = label.removesuffix(INADMISSIBLE)
    if label.startswith(TRANSIENT):
        return mixed(color_of(final(label)), "#000000", _DARKER)
    periodic = period_and_impacts(label)
    return _tinted(*periodic) if periodic else OTHERS[_kind(label)]


def damper_colors(systems: Sequence[str]) -> list[str]:
    """Return a color for each damper, by the name of its system, the same in every picture.

    Other systems, and further ones of the same name, take the unused colors in order.
    """
    used = {DAMPERS["none"], *(DAMPERS[name] for name in systems if name in DAMPERS)}
    others = [color for color in DAMPERS.values() if color not in used] or [*DAMPERS.values()]
    chosen: list[str] = []
    for place, name in enumerate(systems):
        is_own = name in DAMPERS and name not in systems[:place]
        chosen.append(DAMPERS[name] if is_own else others[len(chosen) % len(others)])
    return chosen


def drawn_as(label: str) -> str:
    """Return the name of a label in legends; labels of one color share a name."""
    end = final(label)
    periodic = period_and_impacts(end)
    return label.replace(end, LONG) if periodic and periodic[0] >= len(RAMP) else label


def example_of(word: str) -> str:
    return word.replace(LONG, _EXAMPLE)


def in_order(words: Iterable[str]) -> list[str]:
    """Return names of a legend by period, then those that are not periodic."""
    labels = ordered(example_of(word) for word in words)
    return [word.replace(_EXAMPLE, LONG) for word in labels]


def colors(labels: Iterable[str]) -> dict[str, str]:
    return {label: color_of(label) for label in labels}


def ink_of(label: str) -> str:
    """Return the color of the dots of a regime, dark enough on white paper."""
    label = label.removesuffix(INADMISSIBLE)
    periodic = period_and_impacts(label)
    color = _tinted(*periodic, white=_MOST_WHITE / 2) if periodic else color_of(label)
    luma = _luma(color)
    return color if luma <= _INK else mixed(color, "#000000", 1.0 - _INK / luma)


def hatch_of(label: str) -> str:
    if label.endswith(INADMISSIBLE):
        return hatch_of(label.removesuffix(INADMISSIBLE)) + PASSED
    return _HATCHES.get(label, THROUGH_CHAOS if label.startswith(TRANSIENT) else "")


def patch_look(label: str, color: str = "") -> dict[str, Any]:
    """Return the settings of a patch of a regime: a color, its own by default, and its hatch."""
    color = color or color_of(label)
    look: dict[str, Any] = {"facecolor": color, "linewidth": 0}
    edge = GRAY if label == HATCHED else "white" if is_dark(color) else "black"
    return look | ({"hatch": hatch_of(label), "edgecolor": edge} if hatch_of(label) else {})


def is_dark(color: str) -> bool:
    return _luma(color) < _DARK


def _luma(color: str) -> float:
    """Return the luma of ITU-R BT.601, 0.299 R + 0.587 G + 0.114 B, of channels from 0 to 255."""
    red, green, blue = _channels(color)
    return 0.299 * red + 0.587 * green + 0.114 * blue


def _kind(label: str) -> str:
    return next((kind for kind in OTHERS if label.startswith(kind)), "undetermined")


def _tinted(n: int, k: int, white: float = _MOST_WHITE) -> str:
    """Return the color of nT,k; `white` is the share of white of nT,0."""
    plain = RAMP[min(n, len(RAMP)) - 1]
    if n >= len(RAMP):
        return plain
    if k <= n:
        return mixed(plain, "#ffffff", white * sqrt(1.0 - k / n))
    return mixed(plain, "#000000", _MOST_BLACK * (1.0 - 1.0 / (1 + k - n)))


def mixed(color: str, other: str, share: float) -> str:
    pairs = zip(_channels(color), _channels(other), strict=True)
    return "#" + "".join(f"{round(c + (o - c) * share):02x}" for c, o in pairs)


def _channels(color: str) -> tuple[int, int, int]:
    red, green, blue = (int(color[i : i + 2], 16) for i in (1, 3, 5))
    return red, green, blue
