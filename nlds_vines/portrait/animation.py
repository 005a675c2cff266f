"""A window of an orbit as a film: structure, damper and obstacle in motion, histories beneath.

Matplotlib's own writers make it: Pillow a .gif, and the program ffmpeg, where it is, an .mp4.
"""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib import animation as films
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Rectangle

from nlds_vines.archives.durable import in_one_line, whole
from nlds_vines.errors import RequestError
from nlds_vines.orbits.signals import harmonic_force
from nlds_vines.plotting.notation import typeset
from nlds_vines.plotting.page import styled
from nlds_vines.portrait.picture import BOUNDARIES, DAMPER, FORCE, STRUCTURE
from nlds_vines.portrait.request import PortraitRequest
from nlds_vines.portrait.window_view import View

FRAMES = 24
"""Frames of a forcing period, and in a second: a period lasts a second, whatever the frequency."""

WRITERS = {".gif": "pillow", ".mp4": "ffmpeg"}
"""The writer of matplotlib's that makes a film, by the ending of its name."""

_SIZE, _DPI = (8.0, 4.5), 100  # inches; 800 x 450 pixels
_FLOOR, _PLATE, _TOP = 0.0, 0.18, 0.8  # heights: of the ground, of the structure, of its obstacles
_BODY = (0.26, 0.36)  # lower edge and height of the damper
_HIT = 2  # frames for which what was struck is drawn thick
_COILS = 9


def check_film(path: Path) -> str:
    """Return the writer of a film of this name.

    Raises `RequestError` for another ending, and for one whose program is not installed.
    """
    writer = WRITERS.get(path.suffix.lower())
    if writer is None:
        raise RequestError(f"{path}: a film is one of {', '.join(WRITERS)}")
    if not films.writers.is_available(writer):
        raise RequestError(f"{path}: needs the program {writer}, which is not here; take a .gif")
    return writer


@styled()
def save_film(request: PortraitRequest, view: View, path: Path) -> Path:
    """Draw the first window of a portrait as a film, save it whole or not at all, return its path.

    Arguments: the request, whose `show` says how many forcing periods are seen; the window; the
    path, whose ending chooses one of `WRITERS`.

    Raises `RequestError` as `check_film`, and where nothing can be written.
    """
    name = check_film(path)
    periods = min(request.show, len(view.states) // view.samples)
    figure, update = _stage(request.title, view, periods)
    writer = films.writers[name](fps=FRAMES)
    with in_one_line(f"write {path}"), tempfile.TemporaryDirectory() as folder:
        made = Path(folder) / f"film{path.suffix.lower()}"
        with writer.saving(figure, str(made), _DPI):
            for frame in range(periods * FRAMES):
                update(frame)
                writer.grab_frame()
        with whole(path) as temporary:
            temporary.write_bytes(made.read_bytes())
    return path


def _stage(title: str, view: View, periods: int) -> tuple[Figure, Callable[[int], None]]:
    """Return the figure of a film, and what moves it to a frame."""
    figure = Figure(figsize=_SIZE)
    figure.text(0.06, 0.95, typeset(title), va="center")
    scene = figure.add_axes((0.03, 0.46, 0.94, 0.44))
    below = figure.add_axes((0.09, 0.12, 0.88, 0.28))
    motion = _Motion.of(view, periods)
    cast = _Cast(scene, motion)
    marker = _draw_histories(below, motion)

    def update(frame: int) -> None:
        place = min(round(frame * view.samples / FRAMES), len(motion.turns) - 1)
        cast.move(place, motion.struck_at(place))
        marker.set_xdata([motion.turns[place]] * 2)

    return figure, update


@dataclass(frozen=True)
class _Motion:
    """What moves: times [forcing periods], positions [m], force [N], walls [m] by name."""

    view: View
    turns: np.ndarray
    first: np.ndarray
    damper: np.ndarray | None
    force: np.ndarray
    walls: Mapping[str, float]

    @classmethod
    def of(cls, view: View, periods: int) -> _Motion:
        """Return the motion in the first periods of a window."""
        part = slice(0, periods * view.samples)
        system, states, time = view.column.system, view.states[part], view.time[part]
        return cls(
            view,
            time / system.period,
            states[:, 0],
            states[:, 2] if system.scene.damper else None,
            harmonic_force(system, time),
            {name: float(u) for name, u in system.scene.obstacle(system.parameters).items()},
        )

    def struck_at(self, place: int) -> bool:
        """Tell whether something was struck in the last frames."""
        at = self.turns[place] * self.view.column.system.period
        since = at - _HIT * self.view.column.system.period / FRAMES
        touches = self.view.touches
        return bool(((touches > since) & (touches <= at)).any())

    def relative(self) -> np.ndarray:
        """Return where what strikes is, beside the walls: u = x2 - x1, or x of an oscillator."""
        return self.first if self.damper is None else self.damper - self.first


class _Cast:
    """The bodies, springs and walls of a scene in its axes."""

    def __init__(self, axes: Axes, motion: _Motion) -> None:
        self._motion = motion
        places = [*motion.walls.values(), motion.relative().min(), motion.relative().max()]
        self._low, self._high = min(places), max(places)
        self._pad = 0.12 * (self._high - self._low or 1.0)
        self._wide = 1.2 * self._pad
        self._set_up(axes)
        self._base = self._rectangle(axes, STRUCTURE, _PLATE) if self._carries else None
        self._post = self._rectangle(axes, STRUCTURE, _TOP) if motion.damper is not None else None
        self._body = self._rectangle(axes, DAMPER, _BODY[1])
        self._springs = [Line2D([], [], color="#555555", linewidth=0.9) for _ in range(2)]
        self._walls = {
            name: Line2D([], [], **BOUNDARIES[name]) for name in motion.walls if name != "structure"
        }
        for line in (*self._springs, *self._walls.values()):
            axes.add_line(line)
        arrow: dict[str, Any] = {"color": FORCE, "linewidth": 2.0, "solid_capstyle": "butt"}
        self._arrow = axes.plot([], [], zorder=4, **arrow)[0]
        self._force = axes.text(0.0, _PLATE + 0.1, r"$P\,\cos\,\omega t$", color=FORCE)

    @property
    def _carries(self) -> bool:
        """Whether the walls and the damper stand on the structure, and not on the ground."""
        return not self._motion.view.column.system.scene.grounded

    def _set_up(self, axes: Axes) -> None:
        """Give the axes their limits, the ground, and a fixed wall at the left."""
        swing = self._motion.first if self._carries else np.zeros(1)
        low, high = swing.min() + self._low, swing.max() + self._high
        self._fixed = low - 5 * self._pad
        axes.set_xlim(self._fixed, high + 3 * self._pad)
        axes.set_ylim(-0.1, 1.0)
        axes.set_axis_off()
        axes.axhline(_FLOOR - 0.02, color="#999999", linewidth=0.8)
        axes.axvline(self._fixed, color="#555555", linewidth=2.0)

    def _rectangle(self, axes: Axes, colour: str, height: float) -> Rectangle:
        made = Rectangle((0.0, 0.0), 0.0, height, color=colour, zorder=3)
        axes.add_patch(made)
        return made

    def move(self, place: int, struck: bool) -> None:
        """Put everything where it is at a state, and draw thick what was just struck."""
        motion = self._motion
        u = float(motion.relative()[place])
        carried = float(motion.first[place]) if self._carries else 0.0
        left = carried + self._low - 2 * self._pad
        if self._base is not None:
            self._base.set_bounds(left, _FLOOR, self._high - self._low + 4 * self._pad, _PLATE)
            self._springs[0].set_data(*_coil(self._fixed, left, _PLATE / 2))
        held = self._fixed
        if self._post is not None:
            held = carried + self._place_of_post()
            self._post.set_bounds(held, _PLATE, 0.4 * self._pad, _TOP - _PLATE)
        if motion.damper is not None or not self._carries:
            centre = carried + u - self._side * self._wide / 2
            self._body.set_bounds(centre - self._wide / 2, _BODY[0], self._wide, _BODY[1])
            self._springs[1].set_data(*_coil(held + 0.2 * self._pad, centre, sum(_BODY) - 0.12))
        for name, line in self._walls.items():
            at = carried + self._face_of(name)
            line.set_data([at, at], [_PLATE if self._carries else _FLOOR, _TOP])
            line.set_linewidth(5.0 if struck and name != "limit" else 2.5)
        most = float(np.abs(motion.force).max()) or 1.0
        reach = 2.0 * self._pad * float(motion.force[place]) / most
        self._arrow.set_data([left, left + reach], [_PLATE + 0.06] * 2)
        self._force.set_x(left)

    @property
    def _side(self) -> float:
        """On which side of the body the wall is that it strikes: 1 right, -1 left, 0 both."""
        signs = {self._side_of(name) for name in self._motion.walls}
        return signs.pop() if len(signs) == 1 else 0.0

    def _side_of(self, name: str) -> float:
        """Return on which side of the body a wall is: 1 right, -1 left."""
        return 1.0 if self._motion.walls[name] > float(self._motion.relative().mean()) else -1.0

    def _face_of(self, name: str) -> float:
        """Return where the face of a wall is that the body, which has a width, touches."""
        beside = 0.0 if self._side else self._side_of(name) * self._wide / 2
        return self._motion.walls[name] + beside

    def _place_of_post(self) -> float:
        """Return the left edge of the post that the damper's spring hangs at."""
        if "structure" in self._motion.walls:
            return self._face_of("structure") - 0.4 * self._pad
        return self._low - 2 * self._pad if self._side > 0 else self._high + 1.6 * self._pad


def _coil(start: float, end: float, height: float) -> tuple[np.ndarray, np.ndarray]:
    """Return the zigzag of a spring between two places."""
    across = np.linspace(start, end, 2 * _COILS + 2)
    up = np.full(across.size, height)
    up[1:-1] += 0.045 * (-1.0) ** np.arange(2 * _COILS)
    return across, up


def _draw_histories(axes: Axes, motion: _Motion) -> Line2D:
    """Draw positions over time, and return the line that tells the time."""
    system = motion.view.column.system
    symbol = "$x_1$" if "x1" in system.scene.components else "$x$"
    axes.plot(motion.turns, motion.first, color=STRUCTURE, linewidth=1.0, label=symbol)
    if motion.damper is not None:
        axes.plot(motion.turns, motion.damper, color=DAMPER, linewidth=1.0, label="$x_2$")
    for name, u in motion.walls.items():
        if name != "structure":
            swing = motion.first if motion.damper is not None else np.zeros(motion.turns.size)
            axes.plot(motion.turns, swing + u, label=name, **BOUNDARIES[name])
    axes.set_xlabel("time $t/T$ [forcing periods]")
    axes.set_ylabel("[m]")
    axes.legend(loc="upper right", ncols=4, bbox_to_anchor=(1.0, 1.22))
    return axes.axvline(motion.turns[0], color=FORCE, linewidth=1.2)
