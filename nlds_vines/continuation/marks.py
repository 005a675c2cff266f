"""The mark, the color and the word of each kind of special point, in every picture the same."""

from __future__ import annotations

from typing import Any

from nlds_vines.plotting.style import HUES

MARKS: dict[str, dict[str, Any]] = {
    "LP": {"marker": "o", "color": HUES["green"]},
    "PD": {"marker": "^", "color": HUES["vermillion"]},
    "NS": {"marker": "s", "color": HUES["blue"]},
    "BP": {"marker": "X", "color": HUES["black"]},
    "GR": {"marker": "D", "color": HUES["orange"]},
    "LIM": {"marker": "v", "color": HUES["pink"]},
}
"""The mark of each kind of special point."""

WORDS = {
    "LP": "fold",
    "PD": "period doubling",
    "NS": "torus",
    "BP": "branch point",
    "GR": "grazing",
    "LIM": "limit touched",
}
"""What each kind is, in a word."""
