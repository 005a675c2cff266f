"""Draws every kind of damper with its parameters, for the pages: docs/kinds.png, docs/ssul.png.

    python docs/site/kinds.py

Distances are drawn at rest.  A displacement counts to the right, x2 and x1 from where each body
rests, u = x2 - x1; the line u = 0 is where the damper is at the structure.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle

from nlds_vines.model.scenes import SCENES
from nlds_vines.plotting.style import CM, HUES, STYLE

BODY, DAMPER, WALL, LIMIT = "#dbe3ea", "#f6d9a8", "#8a8a8a", HUES["vermillion"]
GAP = HUES["blue"]
FLOOR = 0.0  # height of the ground
DECK = 0.62  # height of the structure's deck, on which the damper slides
TALL = 1.5  # height of the damper
LEFT, RIGHT = 1.75, 6.3  # the ends of the structure


def box(ax: Axes, x: float, y: float, size: tuple[float, float], color: str, text: str) -> None:
    """Draw a body with its name; (x, y) is its lower left corner."""
    ax.add_patch(Rectangle((x, y), *size, facecolor=color, edgecolor="black", linewidth=0.8))
    ax.text(x + size[0] / 2, y + size[1] / 2, text, ha="center", va="center")


def spring(ax: Axes, ends: tuple[float, float], y: float, name: str) -> None:
    """Draw a spring between two places at a height."""
    a, b = ends
    length = b - a
    x = np.concatenate([[a], np.linspace(a + 0.2 * length, b - 0.2 * length, 12), [b]])
    teeth = np.zeros(14)
    teeth[2:-2] = 0.09 * (-1.0) ** np.arange(10)
    ax.plot(x, y + teeth, color="black", linewidth=0.8)
    ax.text((a + b) / 2, y + 0.14, name, ha="center", va="bottom")


def dashpot(ax: Axes, ends: tuple[float, float], y: float, name: str) -> None:
    """Draw a dashpot between two places at a height."""
    a, b = ends
    middle, w = (a + b) / 2, min(0.18, 0.2 * (b - a))
    ax.plot([a, middle - w], [y, y], color="black", linewidth=0.8)
    cup = [[middle + w, middle - w, middle - w, middle + w], [y + 0.1, y + 0.1, y - 0.1, y - 0.1]]
    ax.plot(*cup, color="black", linewidth=0.8)
    ax.plot([middle + 0.3 * w] * 2, [y - 0.07, y + 0.07], color="black", linewidth=0.8)
    ax.plot([middle + 0.3 * w, b], [y, y], color="black", linewidth=0.8)
    ax.text(middle, y - 0.14, name, ha="center", va="top")


def wall(ax: Axes, x: float, height: float, side: int, foot: float = FLOOR) -> None:
    """Draw a fixed face at `x`, hatched on its left (side -1) or right (side 1)."""
    width = 0.16
    corner = (x if side > 0 else x - width, foot)
    ax.add_patch(
        Rectangle(corner, width, height, hatch="/////", facecolor="white", edgecolor=WALL, lw=0)
    )
    ax.plot([x, x], [foot, foot + height], color="black", linewidth=1.0)


def ground(ax: Axes, left: float, right: float) -> None:
    """Draw the ground, and the wall at its left end."""
    wall(ax, left, 1.3, -1)
    ax.plot([left, right], [FLOOR, FLOOR], color=WALL, linewidth=0.8)


def gap(ax: Axes, ends: tuple[float, float], y: float, name: str) -> None:
    """Draw a distance between two places at a height, with its name."""
    style = {"arrowstyle": "<->", "color": GAP, "linewidth": 0.9, "shrinkA": 0, "shrinkB": 0}
    ax.annotate("", (ends[0], y), (ends[1], y), arrowprops={**style, "mutation_scale": 7})
    ax.text(sum(ends) / 2, y + 0.05, name, ha="center", va="bottom", color=GAP)


def arrow(ax: Axes, begin: tuple[float, float], end: tuple[float, float], name: str) -> None:
    """Draw an arrow, its name beside the head."""
    ax.annotate("", end, begin, arrowprops={"arrowstyle": "-|>", "color": "black", "lw": 0.9})
    upward = end[1] > begin[1]
    ax.text(end[0] + (0.12 if upward else 0.06), end[1], name, ha="left", va="center")


def mark(ax: Axes, x: float, text: str, color: str = WALL) -> None:
    """Draw a dashed line that nothing material stands at, with its name above."""
    ax.plot([x, x], [DECK, DECK + TALL + 0.32], color=color, linewidth=0.9, linestyle="--")
    ax.text(x, DECK + TALL + 0.34, text, ha="center", va="bottom", color=color)


def structure(ax: Axes) -> None:
    """Draw the structure on the ground with its spring, dashpot and force."""
    ground(ax, 0.3, 7.6)
    spring(ax, (0.3, LEFT), 0.44, "$k_1$")
    dashpot(ax, (0.3, LEFT), 0.2, "")
    ax.text(1.02, -0.05, "$c_1$", ha="center", va="top")
    box(ax, LEFT, 0.12, (RIGHT - LEFT, DECK - 0.12), BODY, "$m_1$")
    for x in (LEFT + 0.5, RIGHT - 0.5):
        ax.add_patch(matplotlib.patches.Circle((x, 0.06), 0.06, fc="white", ec="black", lw=0.7))
    arrow(ax, (RIGHT, 0.4), (RIGHT + 0.6, 0.4), r"$P\cos\omega t$")
    arrow(ax, (LEFT + 0.15, -0.28), (LEFT + 0.8, -0.28), "$x_1$")


def damper(ax: Axes, at: float, post: float) -> None:
    """Draw the post at which the joint ends, the joint, and the damper whose left face is `at`."""
    ax.add_patch(Rectangle((post - 0.22, DECK), 0.22, TALL, fc=BODY, ec="black", lw=0.8))
    spring(ax, (post, at), DECK + 1.3, "$k_2$")
    dashpot(ax, (post, at), DECK + 0.95, "$c_2$")
    box(ax, at, DECK + 0.02, (0.8, TALL), DAMPER, "$m_2$")
    arrow(ax, (at + 0.15, DECK + TALL + 0.2), (at + 0.75, DECK + TALL + 0.2), "$x_2$")


def draw_none(ax: Axes) -> None:
    """Draw the structure alone."""
    structure(ax)


def draw_tmd(ax: Axes) -> None:
    """Draw a tuned mass damper."""
    structure(ax)
    damper(ax, 3.6, 2.4)


def draw_ssul(ax: Axes) -> None:
    """Draw the unilateral damper: an obstacle between structure and damper."""
    structure(ax)
    damper(ax, 4.4, 2.2)
    wall(ax, 3.5, 0.45, -1, DECK)
    gap(ax, (2.2, 3.5), DECK + 0.1, "$V$")
    gap(ax, (3.5, 4.4), DECK + 0.1, "$C$")


def _bilateral(ax: Axes, post: float, near: float) -> None:
    """Draw what the kinds of Figures 1a to 1c have in common: damper, obstacle, D and C."""
    structure(ax)
    damper(ax, 4.1, post)
    wall(ax, 5.7, TALL, 1, DECK)
    gap(ax, (near, 4.1), DECK + 0.12, "$D$")
    gap(ax, (4.9, 5.7), DECK + 0.12, "$C$")


def draw_ssbl(ax: Axes) -> None:
    """Draw the bilateral damper: it strikes the structure and an obstacle."""
    _bilateral(ax, 2.9, 2.9)
    ax.plot([2.9, 2.9], [DECK, DECK + TALL], color="black", linewidth=2.0)


def draw_ssvi_b(ax: Axes) -> None:
    """Draw the damper that must not reach the structure."""
    _bilateral(ax, 2.9, 2.9)
    mark(ax, 2.9, "limit", LIMIT)


def draw_ssvi_c(ax: Axes) -> None:
    """Draw the damper that may pass the structure by L."""
    _bilateral(ax, 2.1, 3.25)
    mark(ax, 3.25, "$u=0$")
    mark(ax, 2.4, "limit", LIMIT)
    gap(ax, (2.4, 3.25), DECK + 0.12, "$L$")


def _oscillator(ax: Axes) -> None:
    ground(ax, 0.3, 7.6)
    spring(ax, (0.3, 3.2), 1.0, "$k$")
    dashpot(ax, (0.3, 3.2), 0.6, "$c$")
    box(ax, 3.2, 0.12, (1.3, 1.2), BODY, "$m$")
    for x in (3.5, 4.2):
        ax.add_patch(matplotlib.patches.Circle((x, 0.06), 0.06, fc="white", ec="black", lw=0.7))
    wall(ax, 5.6, 1.3, 1)
    gap(ax, (4.5, 5.6), 0.35, "$C$")
    arrow(ax, (3.85, 1.62), (4.5, 1.62), "$x$")
    arrow(ax, (4.5, 1.0), (5.15, 1.0), "")
    ax.text(4.55, 1.1, r"$P\cos\omega t$", ha="left", va="bottom", fontsize=8)
    arrow(ax, (0.3, -0.28), (0.95, -0.28), r"or the ground moves: $Y\cos\omega t$")


def draw_oscillator(ax: Axes) -> None:
    """Draw one mass with a stop."""
    _oscillator(ax)


def draw_oscillator_2(ax: Axes) -> None:
    """Draw one mass between two stops."""
    _oscillator(ax)
    wall(ax, 2.3, 0.42, -1)
    gap(ax, (2.3, 3.2), 0.12, "$C_2$")


def draw_ball(ax: Axes) -> None:
    """Draw a ball above a table that moves."""
    ax.plot([0.3, 7.6], [FLOOR, FLOOR], color=WALL, linewidth=0.8)
    box(ax, 2.2, 0.45, (3.2, 0.22), BODY, "")
    ax.plot([2.2, 5.4], [0.67, 0.67], color="black", linewidth=1.0)
    ax.text(2.05, 0.56, "table", ha="right", va="center")
    arrow(ax, (4.7, 0.1), (4.7, 0.45), "")
    ax.text(4.85, 0.22, r"$Y\cos\omega t$", ha="left", va="center")
    ax.add_patch(matplotlib.patches.Circle((3.8, 1.65), 0.26, fc=DAMPER, ec="black", lw=0.8))
    ax.text(3.8, 1.65, "$m$", ha="center", va="center")
    style = {"arrowstyle": "<->", "color": GAP, "linewidth": 0.9, "shrinkA": 0, "shrinkB": 0}
    ax.annotate("", (3.8, 0.67), (3.8, 1.39), arrowprops={**style, "mutation_scale": 7})
    ax.text(3.9, 1.03, "$x$", ha="left", va="center", color=GAP)
    arrow(ax, (2.9, 1.9), (2.9, 1.3), "")
    ax.text(2.75, 1.6, "$g$", ha="right", va="center")


DRAWINGS: Mapping[str, Callable[[Axes], None]] = {
    "none": draw_none,
    "tmd": draw_tmd,
    "ssul": draw_ssul,
    "ssbl": draw_ssbl,
    "ssvi-b": draw_ssvi_b,
    "ssvi-c": draw_ssvi_c,
    "oscillator": draw_oscillator,
    "oscillator-2": draw_oscillator_2,
    "ball": draw_ball,
}
"""What draws each kind on axes."""


def figure() -> Figure:
    """Return the figure of all kinds."""
    with matplotlib.rc_context(STYLE):
        rows = -(-len(SCENES) // 2)
        page = Figure(figsize=(16.5 * CM, rows * 4.4 * CM))
        places = page.subplots(rows, 2).flat
        for ax in places:
            ax.set_axis_off()
        for ax, kind in zip(page.axes, SCENES, strict=False):
            DRAWINGS[kind](ax)
            ax.text(3.9, -0.76, kind, fontfamily="monospace", ha="center", va="center")
            ax.set(xlim=(0, 7.9), ylim=(-0.95, 2.85), aspect="equal")
        page.subplots_adjust(left=0.01, right=0.99, bottom=0.0, top=1.0, wspace=0.03, hspace=0.06)
        return page


def first() -> Figure:
    """Return the figure of the paper's damper alone, for the first page."""
    with matplotlib.rc_context(STYLE):
        page = Figure(figsize=(11.0 * CM, 4.3 * CM))
        ax = page.add_axes((0.01, 0.0, 0.98, 1.0))
        ax.set_axis_off()
        DRAWINGS["ssul"](ax)
        ax.text(3.68, 1.14, "obstacle", ha="left", va="center", fontsize=7.5)
        ax.set(xlim=(0, 7.9), ylim=(-0.5, 2.6), aspect="equal")
        return page


def main() -> None:
    """Write the pictures."""
    for name, make in (("kinds.png", figure), ("ssul.png", first)):
        path = Path(__file__).resolve().parents[1] / name
        with matplotlib.rc_context(STYLE):
            make().savefig(path, dpi=200, metadata={"Software": None})
        print(path)


if __name__ == "__main__":
    main()
