"""The panels of a portrait: how each word of `PANELS` is drawn."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from math import ceil
from types import MappingProxyType
from typing import Any, NamedTuple

import matplotlib
import numpy as np
from matplotlib import colormaps
from matplotlib.axes import Axes
from matplotlib.colors import LinearSegmentedColormap, LogNorm
from matplotlib.lines import Line2D
from matplotlib.ticker import MaxNLocator

from nlds_vines.engine.spectrum import Spectrum
from nlds_vines.model.parameters import SIDES
from nlds_vines.model.ratios import HZ
from nlds_vines.model.signals import Motion, displaced
from nlds_vines.plotting.bands import drawable
from nlds_vines.plotting.page import add_legend, size_of
from nlds_vines.plotting.style import DOT, GRAY, GREEN, HUES, SHADES, power_of_ten, typeset
from nlds_vines.portrait.request import (
    EXPONENTS,
    PLANES,
    PortraitRequest,
    motions_in,
    word_of,
)
from nlds_vines.portrait.result import View

STRUCTURE, DAMPER, OBSTACLE = "#7a7a7a", HUES["black"], HUES["vermillion"]
"""Colors of the bodies and the walls, near the paper's gray, black and red."""

# of the harmonic force, of the damper's energy and of the stroboscopic section
FORCE = ENERGY = SECTION = HUES["blue"]
_WALL = {"color": OBSTACLE, "linewidth": 0.9}
BOUNDARIES: Mapping[str, dict[str, Any]] = {
    "obstacle": _WALL,
    "structure": {**_WALL, "color": STRUCTURE},
    "limit": {**_WALL, "linewidth": 0.8, "linestyle": (0, (4, 2))},
    "stop": _WALL,
    "second stop": {**_WALL, "linestyle": (0, (5, 1.5, 1, 1.5))},
    "table": _WALL,
    **dict.fromkeys(SIDES, _WALL),  # of the dampers of hosts
}
"""Lines of the walls and of the limit that the damper must not reach, by name."""

# states beyond which a curve is an image in vector formats, too, and thinner in all
MOST_VECTOR, MOST_THICK = 40_000, 8_000
# the longest period n of an orbit whose moving boundaries are plain lines; others are thin lines
# below the orbit, as the curves would hide each other
LONGEST_PLAIN = 6

MOST_PHASE_PERIODS = 160  # of a phase trajectory; more of a chaotic one blacken the plane

# the panels whose horizontal axis is time
OVER_TIME = ("displacement", "velocity", "relative", "force", "energy", "energy1", "energy2")
# the panels that need states at t = nT alone
OF_SECTIONS = {*OVER_TIME, "section", "section1", "impact-section"} - {"force"}

# of a host: colors of its displacements, and of its dampers; signs of the walls by side
_OF_DISPLACEMENTS = (STRUCTURE, GREEN, HUES["sky"], HUES["orange"], HUES["pink"])
_OF_DAMPERS = (DAMPER, HUES["blue"], HUES["orange"], GREEN, HUES["pink"], HUES["sky"])
_DASHES = ((0, (3, 1.5)), (0, (1, 1)), (0, (5, 1.5, 1, 1.5)))  # of harmonic forces
_SIGNS, _MARKERS = {"+": "$+$", "-": "$-$"}, {"+": "o", "-": "^"}

_IN_PIECES: dict[Any, Any] = {"agg.path.chunksize": 10_000}  # the raster engine draws long paths so
_TIMES = 0.033  # intervals between ticks of time, per point of width
_NUMBER, _NARROW = 33, 150  # points: width of a number; width below which labels are short
_LINE = 0.8  # points, width of a curve
CROWD = 2  # the most columns with headings of one line and full labels


class Place(NamedTuple):
    """A panel of a row; `alone` means that it has its own heading and scales."""

    panel: str
    view: View
    axes: Axes
    first: bool
    last: bool
    alone: bool = False

    @property
    def word(self) -> str:
        """What the panel shows, of `PANELS`."""
        return word_of(self.panel)

    @property
    def system(self) -> Any:
        return self.view.column.system

    @property
    def scene(self) -> Any:
        return self.system.scene


def finish_panel(place: Place, row: Sequence[Place], request: PortraitRequest) -> None:
    axes = place.axes
    axes.tick_params(top=True, right=True)
    if place.word != "shape":
        axes.yaxis.set_major_locator(_ticks(5))
    if place.word in OVER_TIME:
        if axes.xaxis.get_major_ticks(1)[0].label1.get_visible():
            words = "" if len(row) > CROWD else "time "
            axes.set_xlabel(f"{words}$t/T$ [forcing periods]")
        begin, end = place.view.column.window
        axes.set_xlim(begin, min(end, begin + request.show))
        axes.xaxis.set_major_locator(_ticks(ceil(_TIMES * size_of(axes)[0]), integer=True))
    if not (place.first or place.alone or place.word in PLANES):
        axes.set_ylabel("")
    # the legend of a row has every label once, as wide and opaque as a short curve
    entries: dict[str, Line2D] = {}
    for one in row if place.last else ():
        line: Any
        handles, labels = one.axes.get_legend_handles_labels()
        for line, label in zip(handles, labels, strict=True):
            if label not in entries:
                entries[label] = entry = Line2D([], [])
                entry.update_from(line)
                entry.set(alpha=1.0, linewidth=max(line.get_linewidth(), _LINE), rasterized=False)
                entry.set(markersize=max(line.get_markersize(), _LARGE), label=label)
    if entries:
        add_legend(axes, [*entries.values()], "right", handlelength=1.1)


def _ticks(most: int, integer: bool = False) -> MaxNLocator:
    return MaxNLocator(most, integer=integer, steps=[1, 2, 5, 10])


def draw_panel(place: Place, request: PortraitRequest) -> None:
    _PANELS[place.word](place, request)


class Line(NamedTuple):
    """Values over time in a panel, with color, label and what else its look is."""

    values: np.ndarray
    color: str
    label: str
    look: Mapping[str, Any] = MappingProxyType({})


def _over_time(place: Place, request: PortraitRequest) -> None:
    """Draw values over the time that is shown; without samples in between as dots."""
    view, axes, system = place.view, place.axes, place.system
    count = request.show * view.samples
    time = view.time[:count]
    states = view.states[:count]
    across = time / system.period
    look: dict[str, Any] = {"linewidth": _LINE}
    if view.samples == 1:
        look = {**DOT, "markersize": _SMALL}
    for line in _lines_over_time(place, request, time, states):
        own = {"color": line.color, "label": line.label, **line.look}
        axes.plot(across, line.values, **{**look, **own})
    match place.word:
        case "displacement":
            axes.set_ylabel("displacement [m]")
            _draw_moving_walls(place, request, across, states)
        case "velocity":
            axes.set_ylabel("velocity [m/s]")
        case "relative":
            _label_and_walls(place, request)
        case "force":
            axes.set_ylabel("force [kN]")
        case bodies:
            body = bodies.removeprefix("energy")
            axes.set_ylabel(f"$E_{body}$ [J]" if body else "energy [J]")
            axes.set_ylim(bottom=0)


def _lines_over_time(
    place: Place, request: PortraitRequest, time: np.ndarray, states: np.ndarray
) -> list[Line]:
    """Return the lines of a panel over time, without the walls."""
    match place.word:
        case "displacement" | "velocity":
            part = int(place.word == "velocity")
            lines = []
            for motion in motions_in(place.word, place.system, request.of):
                label = typeset(motion.owner) or f"${motion.symbols[part]}$"
                color = _color_of(place, motion.body, request)
                lines.append(Line(motion.of(states, part), color, label))
            return lines
        case "relative":
            (motion,) = _motions(place, request)
            color = _color_of(place, motion.body, request)
            return [Line(motion.of(states), color, f"${motion.symbols[0]}$")]
        case "force":
            return _forces(place, request, time, states)
        case _:
            return _energies(place, request, states)


def _energies(place: Place, request: PortraitRequest, states: np.ndarray) -> list[Line]:
    """Return the energies: of the structure green, of the only damper blue."""
    (of_structure, _), *of_dampers = place.system.energy_signals.items()
    lines = []
    if place.word != "energy2":
        values = place.system.signal(of_structure).of(states)
        lines.append(Line(values, GREEN, "$E_1$"))
    if place.word != "energy1":
        for name, body in of_dampers:
            signal = place.system.signal(name)
            several = len(of_dampers) > 1
            color = _color_of(place, body, request) if several else ENERGY
            label = f"$E_2$ of {typeset(body)}" if several else "$E_2$"
            lines.append(Line(signal.of(states), color, label))
    return lines


def _forces(
    place: Place, request: PortraitRequest, time: np.ndarray, states: np.ndarray
) -> list[Line]:
    """Return the harmonic forces, dashed, and the contact forces, all in kN."""
    lines = []
    harmonic = place.system.harmonic_forces(time)
    for i, (name, values) in enumerate(harmonic.items()):
        label = r"$P\,\cos\,\omega t$" if len(harmonic) == 1 else typeset(name)
        if place.scene.shaken:
            label = "moving ground"
        dashes = {"linestyle": _DASHES[i % len(_DASHES)]}
        lines.append(Line(values / 1000, FORCE, label, dashes))
    contacts = place.system.contact_forces(states)
    for name, values in contacts.items():
        if name in place.system.damper_names:
            line = Line(values / 1000, _color_of(place, name, request), typeset(name))
        else:
            label = _words(name) if len(contacts) > 1 else "contact"
            line = Line(values / 1000, OBSTACLE, label, BOUNDARIES[name])
        lines.append(line)
    return lines


def _draw_moving_walls(
    place: Place, request: PortraitRequest, across: np.ndarray, states: np.ndarray
) -> None:
    """Draw the walls that displacements reach; walls on another body move with it."""
    for motion in motions_in("displacement", place.system, request.of):
        for name, u in motion.walls.items():
            look: dict[str, Any] = {"label": _words(name), **BOUNDARIES[name]}
            if motion.carrier is None:
                place.axes.axhline(u, **look)
            elif name != "structure" and place.view.samples > 1:  # which is drawn as a body
                place.axes.plot(across, displaced(motion.carrier, states, 0) + u, **look)


def _label_and_walls(place: Place, request: PortraitRequest) -> None:
    """Label the displacement along a spring, and draw the walls and, if it has any, touches."""
    axes, (motion,) = place.axes, _motions(place, request)
    axes.set_ylabel(f"{_label_of(motion, 0)} [m]")
    for name, r in motion.walls.items():
        axes.axhline(r, label=_words(name), **BOUNDARIES[name])
    if motion.shows_touches:
        contacts = place.view.contacts
        own = contacts[contacts["damper"] == motion.body]
        places = [motion.walls[wall] for wall in own["wall"].tolist()]
        look: dict[str, Any] = {"color": OBSTACLE, "markersize": _LARGE, "zorder": 5}
        axes.plot(own["touch"] / place.system.period, places, label="touch", **look, **DOT)


def _words(boundary: str) -> str:
    words = {"stop": "stop $C$", "second stop": "stop $-C_2$", **dict.fromkeys(SIDES, "wall")}
    return words.get(boundary, boundary)


def _motions(place: Place, request: PortraitRequest) -> Sequence[Motion]:
    """Return the motions of a panel: that of the body which its name has, the first if it has none.

    The plane of all bodies has them all.
    """
    motions = motions_in(place.word, place.system, request.of)
    if place.word == "phase":
        return motions
    owner = place.panel.partition(":")[2]
    return [next((one for one in motions if one.body == owner), motions[0])]


def _label_of(motion: Motion, part: int) -> str:
    """Return the symbol of a displacement or, with `part` 1, of its rate, with its owner."""
    return _with_owner(f"${motion.symbols[part]}$", motion.owner)


def _with_owner(symbol: str, owner: str) -> str:
    return f"{symbol} of {typeset(owner)}" if owner else symbol


def _plane(place: Place, request: PortraitRequest) -> None:
    """Draw phase trajectories of one cycle, their sections, and the walls.

    Trajectories are thin if they are long, and images beyond `MOST_VECTOR` states.  In the plane of
    the damper the walls move with the structure unless they stand on the ground.
    """
    view, axes, motions = place.view, place.axes, _motions(place, request)
    # with the state before, so that the curve of a period closes
    states = view.states[-(min(view.cycle, MOST_PHASE_PERIODS) * view.samples + 1) :]
    is_long = len(states) > MOST_VECTOR
    width, alpha = (0.25, 0.6) if is_long else (_LINE if len(states) < MOST_THICK else 0.4, 1.0)
    for motion in motions:
        with matplotlib.rc_context(_IN_PIECES):
            color = _color_of(place, motion.body, request)
            axes.plot(
                motion.of(states), motion.of(states, 1), color=color, linewidth=width,
                alpha=alpha, rasterized=is_long, label=typeset(motion.body),
            )  # fmt: skip
    look: dict[str, Any] = {}
    if not 0 < view.period <= LONGEST_PLAIN:
        look = {"linewidth": 0.25, "alpha": 0.35, "zorder": 1}
    for motion in motions:
        for name, u in motion.walls.items():
            if motion.carrier is None:
                axes.axvline(u, label=_words(name), **BOUNDARIES[name])
                continue
            places = displaced(motion.carrier, states, 0) + u
            with matplotlib.rc_context(_IN_PIECES):
                axes.plot(
                    places, displaced(motion.carrier, states, 1), label=_words(name),
                    **{**BOUNDARIES[name], **look, "rasterized": is_long},
                )  # fmt: skip
    n = view.period
    size = _LARGE if 0 < n < _FEW else _SMALL
    for motion in motions:
        last = view.section[-n:]  # all where n is 0
        axes.plot(
            motion.of(last), motion.of(last, 1), color=SECTION, markersize=size, zorder=5,
            label="$t=nT$", **DOT,
        )  # fmt: skip
    if place.word == "phase":
        axes.set_xlabel("displacement [m]")
        axes.set_ylabel("velocity [m/s]")
    else:
        _label_plane(axes, motions[0])


def _label_plane(axes: Axes, motion: Motion) -> None:
    axes.set_xlabel(f"{_label_of(motion, 0)} [m]")
    axes.set_ylabel(f"{_label_of(motion, 1)} [m/s]")
    axes.xaxis.set_major_locator(_ticks(min(6, int(size_of(axes)[0] / _NUMBER))))


# ---- sections ------------------------------------------------------------------------------------


CROWDED = 1500  # points beyond which colors show the density, as single points overlap
_CELLS = 160  # along each side of the plane, in which points are counted
_PALEST = 0.9  # of the color map, whose yellow end is too pale for dots
_LARGE, _SMALL, _SMALLEST = 3.4, 1.7, 0.9  # points, sizes of few, more and many dots
_FEW = 40  # the number of dots below which they are large


def _section(place: Place, request: PortraitRequest) -> None:
    """Draw the stroboscopic section of the damper or the structure at the phase in the request."""
    view, (motion,) = place.view, _motions(place, request)
    sample = round(request.section_phase * view.samples) % view.samples
    section = view.section_at(sample)[-view.period :]  # all where it is 0
    points = np.column_stack([motion.of(section), motion.of(section, 1)])
    label = rf"$\phi={sample / view.samples:.3g}$" if sample else "$t=nT$"  # phi in turns
    _scatter(place.axes, points, SECTION, label)
    place.axes.margins(0.06)
    _label_plane(place.axes, motion)


def _impact_section(place: Place, request: PortraitRequest) -> None:
    """Draw the phase of the force and the approach speed of each touch, of one cycle if any."""
    view, axes = place.view, place.axes
    colors = _colors_of_walls(place)
    for name, points in view.impact_section.items():
        if len(points):
            color, label, marker = colors[name]
            _scatter(axes, points, color, label, is_shaded=False, marker=marker)
    if not len(view.contacts):
        axes.text(0.5, 0.5, "no impacts", ha="center", va="center", transform=axes.transAxes)
    axes.set_xlim(0.0, 2.0 * np.pi)
    axes.set_ylim(0.0, 1.08 * max(axes.dataLim.y1, 0.0) or 1.0)
    axes.set_xlabel(r"phase at touch $\varphi$ [rad]")
    axes.set_ylabel("approach speed [m/s]")


def _scatter(
    axes: Axes, points: np.ndarray, color: str, label: str, is_shaded: bool = True, **marks: Any
) -> None:
    many = len(points)
    size = _LARGE if many < _FEW else _SMALL if many < CROWDED else _SMALLEST
    if many < CROWDED or not is_shaded:
        look = {"color": color, "markersize": size, "label": label, **DOT, **marks}
        axes.plot(points[:, 0], points[:, 1], rasterized=many > CROWDED, **look)
        return
    # for each point the number of points in its cell of a grid over all points
    low, span = points.min(axis=0), np.ptp(points, axis=0)
    places = ((points - low) / np.where(span > 0, span, 1.0) * _CELLS).astype(int)
    cells = np.minimum(places, _CELLS - 1) @ np.array([1, _CELLS])
    near = np.bincount(cells)[cells]
    order = np.argsort(near, kind="stable")  # dense ones on top
    shades = colormaps[SHADES](np.linspace(0.0, _PALEST, 64))
    shading = LinearSegmentedColormap.from_list("counts", shades)
    axes.scatter(
        points[order, 0], points[order, 1], s=size**2, c=near[order], cmap=shading,
        norm=LogNorm(1.0, max(2.0, float(near.max()))), linewidths=0, rasterized=True,
    )  # fmt: skip
    axes.plot([], [], color=shading(0.5), label=label, **DOT)


# ---- spectra -------------------------------------------------------------------------------------


DEPTH = 100.0  # the range of a spectrum, in decibels below the highest line of its row
LEAST = 1.0e-4  # the relative amplitude above which a line must be visible
SHORTEST, LONGEST = 4, 8  # the bounds of the highest frequency, in multiples of the force's
FINE = 240  # periods above which the curve of a spectrum is thinner, as its bins are close
ZERO = -400.0  # the decibels at which an amplitude of exactly zero is drawn


def _draw_spectrum(place: Place, request: PortraitRequest) -> None:
    view, axes, several = place.view, place.axes, len(place.view.spectra) > 1
    shades = [HUES[name] for name in ("black", "vermillion", "blue", "green", "orange", "sky")]
    for i, spectrum in enumerate(view.spectra):
        with np.errstate(divide="ignore"):
            heights = np.maximum(spectrum.decibels(), ZERO)
        look: dict[str, Any] = {"color": shades[i % len(shades)]}
        look["linewidth"] = 0.5 if spectrum.periods <= FINE else 0.3
        if several:
            look["label"] = _symbol(place, spectrum)
        axes.plot(spectrum.order[1:], heights[1:], **look)
    omega, is_narrow = place.system.parameters["omega"], size_of(axes)[0] < _NARROW
    ratio, force = r"$\Omega/\omega$", rf"$\omega$ = {omega:g} rad/s"
    if request.frequency == HZ:
        ratio, force = "$F/f$", f"$f$ = {omega / (2 * np.pi):g} Hz"
    axes.set_xlabel(f"{ratio}, {force}" if is_narrow else f"frequency [multiples of {force}]")
    units = dict.fromkeys(spectrum.unit for spectrum in view.spectra)
    name = "amplitude" if several else _symbol(place, view.spectrum)
    axes.set_ylabel(f"{name} [dB re 1 {', '.join(units)}]")
    if several or (share := view.share) is None:
        return
    is_tiny = 0 < share < 5e-4
    value = f"${power_of_ten(f'{share:.0e}')}$" if is_tiny else f"{share:.1%}"
    lines = f"{view.comb if view.comb > 1 else ''}T lines:"
    words = f"off {lines}\n{value}" if is_narrow else f"power outside {lines} {value}"
    look = {"ha": "right", "va": "top", "fontsize": 7.5}
    axes.text(0.985, 0.95, words, transform=axes.transAxes, **look)


def _symbol(place: Place, spectrum: Spectrum) -> str:
    """Return the modulus of a spectrum's quantity in LaTeX, with the owner's name."""
    signal = place.system.signal(spectrum.quantity)
    return _with_owner(f"$|{signal.symbol}|$", signal.owner)


def limit_spectra(row: Sequence[Place]) -> None:
    """Give the spectra of a row the same limits: `DEPTH` below the highest line, one end."""
    spectra = [spectrum for place in row for spectrum in place.view.spectra]
    highest = max(float(spectrum.decibels()[1:].max()) for spectrum in spectra)
    if highest > ZERO:
        row[0].axes.set_ylim(highest - DEPTH, highest + 0.2 * DEPTH)
    end = SHORTEST
    for spectrum in spectra:  # to the last line above LEAST
        amplitude = spectrum.amplitude[1:]
        strong = spectrum.order[1:][amplitude > LEAST * amplitude.max()]
        end = max(end, ceil(strong[-1] + 0.2) if strong.size else 0)
    for place in row:
        place.axes.set_xlim(0, min(end, LONGEST))


def _exponents(place: Place, request: PortraitRequest) -> None:
    axes, spectrum = place.axes, place.view.exponents
    if spectrum is None:
        return
    periods = np.arange(1, len(spectrum.times) + 1)
    shades = (HUES["blue"], HUES["vermillion"], HUES["green"], HUES["gray"])
    running = drawable(spectrum.running)[:, : len(shades)]  # the largest of a host
    axes.axhline(0.0, color=GRAY, linewidth=0.5)
    for i, (width, shade) in enumerate(zip(spectrum.widths, shades, strict=False)):
        axes.plot(periods, running[:, i], color=shade, linewidth=_LINE, label=rf"$\lambda_{i + 1}$")
        end = running[-1, i]
        axes.fill_between(periods, end - width, end + width, color=shade, alpha=0.2, linewidth=0)
    settled = running[len(running) // 20 :]
    low, high = np.nanmin(settled, initial=0.0), np.nanmax(settled, initial=0.0)
    room = 0.1 * (high - low)
    axes.set_ylim(low - room, high + room)
    axes.set_xscale("log")
    axes.set_xlim(1, len(periods))
    axes.set_xlabel("forcing periods after the window")
    axes.set_ylabel("exponents [1/s]")


# ---- hosts ---------------------------------------------------------------------------------------


INSTANTS = 8  # of a period, whose shapes of a host are drawn
_MOST_NAMES = 12  # degrees of freedom of a host whose names stand beside its shape


def _color_of(place: Place, body: str, request: PortraitRequest) -> str:
    """Return the color of a body: of a damper by its number, else by that of the displacement."""
    dampers = place.system.damper_names
    if body in dampers:
        return _OF_DAMPERS[dampers.index(body) % len(_OF_DAMPERS)]
    bodies = [one.body for one in place.system.motions(request.of).bodies]
    names = [name for name in bodies if name not in dampers]
    return _OF_DISPLACEMENTS[names.index(body) % len(_OF_DISPLACEMENTS)]


def _shape(place: Place, request: PortraitRequest) -> None:
    """Draw a host at instants of the last period, its largest displacements, and those of masses.

    The degrees of freedom are those that the ground moves: no rotations of a beam.
    """
    view, axes, system = place.view, place.axes, place.system
    dofs = system.chain
    states = view.states[-min(view.cycle, MOST_PHASE_PERIODS) * view.samples :]
    levels, step = np.arange(len(dofs)), 0.05 * (len(dofs) - 1)
    paths = np.stack([displaced(system.displacement(dof)[0], states, 0) for dof in dofs])
    low, high = paths.min(axis=1), paths.max(axis=1)
    axes.fill_betweenx(levels, low, high, color=GRAY, alpha=0.25, linewidth=0)
    every = max(1, view.samples // INSTANTS)
    for i, path in enumerate(paths[:, -view.samples :][:, ::-every].T):
        axes.plot(path, levels, color=GRAY, linewidth=0.5, label="instants" if not i else None)
    for ends in (low, high):
        axes.plot(ends, levels, color=STRUCTURE, linewidth=1.4, label="largest")
    axes.axvline(0.0, color=GRAY, linewidth=0.5, linestyle=":")
    raised = dict.fromkeys(dofs, 0)  # the masses on each degree of freedom so far
    for damper in system.dampers:
        if damper.attached_to in raised:
            raised[damper.attached_to] += 1
            level = dofs.index(damper.attached_to) + step * raised[damper.attached_to]
            path = displaced(system.displacement(damper.name)[0], states, 0)
            color = _color_of(place, damper.name, request)
            ends = [path.min(), path.max()]
            axes.plot(ends, [level] * 2, color=color, linewidth=1.4, label=typeset(damper.name))
    every = ceil(len(dofs) / _MOST_NAMES)
    shown = levels[::-1][::every][::-1]
    axes.set_yticks(shown, [typeset(dofs[i]) for i in shown])
    axes.set_ylim(-2 * step, levels[-1] + (2 + max(raised.values())) * step)
    axes.set_xlabel("displacement [m]")
    axes.xaxis.set_major_locator(_ticks(min(6, int(size_of(axes)[0] / _NUMBER))))


def _colors_of_walls(place: Place) -> dict[str, tuple[str, str, str]]:
    """Return color, words and marker of the touches at each wall, by its name."""
    dampers = place.system.damper_names
    looks = {}
    for word, (damper, wall) in place.scene.dampers_and_walls.items():
        if damper:
            color = _OF_DAMPERS[dampers.index(damper) % len(_OF_DAMPERS)]
            looks[word] = color, f"{typeset(damper)} {_SIGNS[wall]}", _MARKERS[wall]
        else:
            looks[word] = BOUNDARIES[wall]["color"], _words(wall), "o"
    return looks


_PANELS: Mapping[str, Callable[[Place, PortraitRequest], None]] = {
    **dict.fromkeys(OVER_TIME, _over_time),
    **dict.fromkeys(("phase", "phase1", "phase2"), _plane),
    **dict.fromkeys(("section", "section1"), _section),
    "shape": _shape,
    "impact-section": _impact_section,
    "spectrum": _draw_spectrum,
    EXPONENTS: _exponents,
}
