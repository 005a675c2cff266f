"""A structure with its dampers and gaps as a drawing (SVG), from the table of a system."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from html import escape
from textwrap import wrap
from typing import Any

import nlds_vines as nv

STOREY = 46  # pixels from floor to floor
MOST_FLOORS = 14  # floors that are drawn; of more, those that dampers hang on and the highest ones
_WIDTH = 560
_LEFT, _RIGHT = 40, 220  # pixels, ends of a floor
_CHARACTERS = 52  # of a line beside the drawing
_INK, _DAMPER = "#20303c", "#d55e00"


def drawn_system(system: nv.System, words: str) -> str:
    """Return the drawing of a system, titled by its `words`.

    Floors stand above one another in the order of the degrees of freedom; a damper's box hangs on
    its floor, with a bar for each wall, and its numbers beside it.  Lengths are not to scale.
    """
    dampers = dampers_in_words(system)
    floors = _floors(system, dampers)
    height = STOREY * (len(floors) + 1) + 20
    places = {name: height - 30 - STOREY * (i + 1) for i, name in enumerate(floors)}
    ground = height - 30
    parts = [_line(_LEFT - 25, ground, _RIGHT + 25, ground, 2)]
    for x in range(_LEFT - 20, _RIGHT + 26, 12):
        parts.append(_line(x, ground + 8, x + 8, ground, 1))
    below = ground
    for name in floors:
        y = places[name]
        parts.append(_line(_LEFT, y, _RIGHT, y, 6))
        parts += [_line(x, y, x, below, 2) for x in (_LEFT + 12, _RIGHT - 12)]
        parts.append(_text(_LEFT - 8, y + 4, name, "end"))
        below = y
    seen: dict[str, int] = {}
    for one in dampers:
        parts += _damper(one, places, seen)
    described = [", ".join(one["lines"]) for one in dampers] or ["no damper"]
    label = escape(f"{words}: {'; '.join(described)}")
    return (
        f'<figure><svg viewBox="-70 0 {_WIDTH + 70} {height}" role="img" aria-label="{label}">'
        f"{''.join(parts)}</svg><figcaption>{escape(words)}</figcaption></figure>"
    )


def _floors(system: nv.System, dampers: Sequence[Mapping[str, Any]]) -> list[str]:
    """Return the names of the floors that are drawn, from below."""
    floors = list(system.chain) or ["structure"]
    hung = {place for one in dampers for place in one["places"]}
    if len(floors) > MOST_FLOORS:
        floors = [name for name in floors if name in hung or name in floors[-3:]]
    return [*floors, *sorted(hung.difference(floors))]


def dampers_in_words(system: nv.System) -> list[dict[str, Any]]:
    """Return name, places, sides of walls and lines of words of each damper of a system."""
    table = system.to_table()
    described = []
    for entry in table.get("dampers", []):
        places = entry["attached_to"]
        numbers = [
            f"{entry[key]:.4g} {unit}"
            for key, unit in (("m", "kg"), ("k", "N/m"), ("c", "N s/m"))
            if entry.get(key)
        ]
        lines = [f"{entry['name']}: {', '.join(numbers)}"]
        walls = entry.get("walls", [])
        for wall in walls:
            constants = [
                f"{key} = {value:.4g}"
                for key, value in wall.items()
                if key not in ("gap", "side", "law")
            ]
            law = wall.get("law", "hertz")
            gap = f"gap {1e3 * wall['gap']:.4g} mm on side {wall['side']}"
            lines.append(f"{gap}, {law} {', '.join(constants)}".rstrip())
        one = {
            "name": entry["name"],
            "places": [places] if isinstance(places, str) else list(places),
            "sides": [wall["side"] for wall in walls],
            "lines": lines,
        }
        described.append(one)
    if described or not system.damper_names:
        return described
    parameters = table["parameters"]
    numbers = [
        f"{key} = {parameters[key]:.4g} {unit}"
        for key, unit in (
            ("m2", "kg"), ("k2", "N/m"), ("c2", "N s/m"), ("C", "m"), ("D", "m"), ("L", "m"),
        )
        if parameters.get(key)
    ]  # fmt: skip
    sides = ["+"] * ("C" in parameters) + ["-"] * ("D" in parameters)
    lines = [f"damper: {', '.join(numbers)}"]
    if sides:
        lines.append(f"law {table.get('law', 'hertz')}")
    return [{"name": "damper", "places": ["structure"], "sides": sides, "lines": lines}]


def _damper(one: Mapping[str, Any], places: Mapping[str, float], seen: dict[str, int]) -> list[str]:
    """Return the parts of a damper: its box between its walls, and its numbers."""
    first = one["places"][0]
    y = places[first]
    number = seen.get(first, 0)
    seen[first] = number + 1
    x = _LEFT + 60 + 62 * number
    parts = []
    if len(one["places"]) > 1:
        parts.append(_line(x, y, x + 30, places[one["places"][1]], 3, _DAMPER))
    else:
        parts.append(f'<rect x="{x}" y="{y - 23}" width="26" height="18" fill="{_DAMPER}" rx="2"/>')
        parts.append(_line(x + 13, y - 5, x + 13, y - 3, 3, _DAMPER))
        if "-" in one["sides"]:
            parts.append(_line(x - 8, y - 27, x - 8, y, 4))
        if "+" in one["sides"]:
            parts.append(_line(x + 34, y - 27, x + 34, y, 4))
    lines = [part for line in one["lines"] for part in wrap(line, _CHARACTERS)]
    for i, line in enumerate(lines):
        below = 13 * (i + len(lines) * number)
        parts.append(_text(_RIGHT + 20, y - 20 + below, line, "start"))
    return parts


def _line(x: float, y: float, end_x: float, end_y: float, width: float, color: str = _INK) -> str:
    return (
        f'<line x1="{x}" y1="{y}" x2="{end_x}" y2="{end_y}" stroke="{color}" '
        f'stroke-width="{width}"/>'
    )


def _text(x: float, y: float, text: str, anchor: str) -> str:
    return (
        f'<text x="{x}" y="{y}" text-anchor="{anchor}" font-size="11" fill="{_INK}">'
        f"{escape(text)}</text>"
    )
