"""The archive of a scan: its path as an object, its request, and the exact orbits of its cells.

No kernels are loaded before an orbit is asked for.
"""

from __future__ import annotations

import os
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from nlds_vines.archives.archive import ArchivePath, ArchiveView, read
from nlds_vines.archives.files import parse_toml
from nlds_vines.archives.provenance import SCAN
from nlds_vines.bifurcation.request import Scan, load_scan
from nlds_vines.errors import RequestError, at, number, shown, truth, unknown, whole
from nlds_vines.model.axis import Axis
from nlds_vines.model.parameters import INITIAL, PHASE, component_of
from nlds_vines.model.ratios import ratios_in
from nlds_vines.model.system import System
from nlds_vines.runs.progress import Tell

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from nlds_vines.engine.engine import Beginning
    from nlds_vines.engine.one_orbit import Orbit


class ScanArchive(ArchivePath):
    """A scan's archive: datasets by name, and a path, which is accepted wherever a path is.

    Examples
    --------
    >>> import nlds_vines as nv
    >>> scan = nv.scan("tmd", vary={"omega": {"values": [6.0]}}, record=["energy"], quiet=True)
    >>> scan.request.system.name, scan.request.want
    ('tmd', ('energy',))
    >>> scan["E1max"].shape, scan["omega"].tolist()
    ((1, 1), [6.0])
    """

    def __getitem__(self, name: str) -> np.ndarray:
        """Return a dataset or the values of a dimension; `RequestError` for another name."""
        with self.read() as view:
            return view[name]

    @property
    def request(self) -> Scan:
        """The scan; computed again, it gives the same numbers."""
        if self.named is not None and not self.is_file():
            raise RequestError(f"{shown(str(self))}: there is no such file")
        with self.read() as view:
            return scan_of(view)

    def orbit(
        self,
        *,
        start: int | str = 0,
        record: Collection[str] | None = None,
        quiet: bool = False,
        **values: float,
    ) -> Orbit:
        """Return the orbit of the cell nearest to `values`, see `nlds_vines.orbit_of`."""
        return orbit_of(self, start=start, record=record, quiet=quiet, **values)

    def plot(self, show: str | None = None, ax: Axes | None = None) -> Figure:
        """Return its picture as a Matplotlib figure, see `nlds_vines.plot`."""
        from nlds_vines.bifurcation.picture.drawing import PICTURE

        return PICTURE.of(self, show, ax)


def scan_in(path: str | os.PathLike[str]) -> ScanArchive:
    return ScanArchive.of(path)


def scan_of(view: ArchiveView) -> Scan:
    """Return the scan of an open archive; `RequestError` if this version reads it differently."""
    if view.content != SCAN:
        raise RequestError(f"{view.path} holds a {view.content}, not a scan")
    text, digest = view.text("scan"), view.text("scan_hash")
    with at(f"{view.path}: its scan"):
        scan = load_scan(parse_toml(text, "the attribute scan"))
    if scan.hash != digest:
        raise RequestError(
            f"{view.path}: its scan is damaged, or means something else to this version; "
            f"it was made by {view.attrs.get('source', 'an unknown version')}"
        )
    return scan


# ---- orbits of cells -----------------------------------------------------------------------------


STEP = {"up": 1, "down": -1}  # the step of a sweep along the last axis, whose values ascend
Place = tuple[int, ...]  # the index of a cell along each axis


class CellStart(NamedTuple):
    """A start (x1, v1, x2, v2) [m, m/s], None for rest, and its description."""

    state: tuple[float, ...] | None
    words: str


def values_at(scan: Scan, place: Place) -> dict[str, float]:
    """Return the varied parameters and initial conditions of a cell by name [SI units]."""
    if scan.sampled is not None:
        return {name: float(column[place[0]]) for name, column in scan.sampled.columns.items()}
    pairs = zip(scan.axes, place, strict=True)
    return {axis.name: float(axis.values[i]) for axis, i in pairs}


def system_at(scan: Scan, place: Place, settings: Mapping[str, float] | None = None) -> System:
    """Return the system of a cell; `settings` override parameters."""
    varied = {name: v for name, v in values_at(scan, place).items() if name not in INITIAL}
    return scan.system.with_(**{**varied, **(settings or {})})


def own_states(
    scan: Scan,
    cells: np.ndarray,
    initial: Mapping[str, np.ndarray],
    lanes: np.ndarray,
    tell: Tell | None = None,
    system: System | None = None,
) -> np.ndarray:
    """Return where orbits that follow no other one are at their first section; rest for sweeps.

    `initial` are the components of the state and the phase that axes set in the `cells` (n,); an
    orbit that begins at another phase is followed to the next section.  `lanes` (n,) are the
    numbers of the starts in their cells.  `system` is one with other parameters than the scan's.
    Returns states (n, ...) of the kernels.
    """
    from nlds_vines.engine.engine import engine_for  # with kernels, which take long to load

    how = scan.method, scan.settings
    return engine_for(system or scan.system).states(cells, scan.start, lanes, initial, how, tell)


def swept_before(scan: Scan, place: Place, lane: int) -> list[Place]:
    """Return the cells that a sweep passes before `place`, in its order; none without a sweep."""
    if not scan.start.sweeps:
        return []
    step = STEP[scan.start.sweeps[lane]]
    first = 0 if step > 0 else scan.shape[-1] - 1
    return [(*place[:-1], i) for i in range(first, place[-1], step)]


def recorded_start(
    scan: Scan,
    arrays: Mapping[str, np.ndarray],
    place: Place,
    lane: int,
    system: System,
    moved: Mapping[str, float] | None = None,
) -> CellStart:
    """Return the start of an orbit; `moved` are initial conditions that override those of the cell.

    In a sweep, the start is read from the results `arrays`.
    """
    if scan.start.sweeps:
        sweep, before = scan.start.sweeps[lane], swept_before(scan, place, lane)
        if not before:
            return CellStart(None, f"rest, the beginning of the sweep {sweep}")
        for name, where, words in (
            ("section", (*before[-1], lane, -1), "the cell before"),
            ("orbit_point", (*place, lane), "a point of its orbit"),
        ):
            if name in arrays and np.isfinite(state := arrays[name][where]).all():
                return CellStart(tuple(state.tolist()), f"the sweep {sweep}: {words}")
        return CellStart(None, f"rest: the archive does not hold the states of the sweep {sweep}")
    initial = dict[str, np.ndarray]()
    if scan.start.policy == "random":
        words = f"{scan.start.names[lane]} (seed {scan.start.seed})"
    else:
        values = {name: v for name, v in values_at(scan, place).items() if name in INITIAL}
        values |= moved or {}
        if not values and not scan.start.state and not scan.start.phase:
            return CellStart(None, "rest")
        initial = {component_of(name): np.array([value]) for name, value in values.items()}
        if scan.start.phase and PHASE not in values:
            values[PHASE] = scan.start.phase
        words = ", ".join(f"{name} = {value:g}" for name, value in values.items())
        words = "the start of the sliders" if moved else words or "the given state"
    from nlds_vines.engine.engine import engine_for

    cell = np.atleast_1d(system.cells())
    state = own_states(scan, cell, initial, np.array([lane]), system=system)
    (begun,) = engine_for(system).begun_states(cell, state)
    return CellStart(tuple(begun.tolist()), words)


@dataclass(frozen=True)
class CellOrbit:
    """The orbit of one start in one cell of a scan."""

    scan: Scan
    begin: Beginning
    start: str  # its name
    label: str = ""  # in the archive; empty if none is recorded

    def orbit(self, record: Collection[str] | None = None, quiet: bool = False) -> Orbit:
        from nlds_vines.engine.simulation import checked_record

        words, scan = checked_record(self.begin.system, record), self.scan
        return self.begin.follow(words, scan.transient, scan.periods, quiet=quiet)

    def traced(self, begin: int, end: int, samples: int, quiet: bool = False) -> Orbit:
        """Return the orbit from one forcing period to another with states in between.

        These end steps of the integration, which would change a chaotic orbit: each period is
        traced by itself, from the section of the orbit without them.
        """
        count, first, system = end - begin, self.begin, self.begin.system
        words = ("section", "impacts") if system.scene.walls else ("section",)
        whole_orbit = first.follow(words, begin, count, quiet=quiet)
        assert whole_orbit.section is not None
        states = np.empty((count, samples, whole_orbit.section.shape[1]))
        one = first.after(begin)
        for i in range(count):
            if i:
                one = first.resumed(begin + i, whole_orbit.section[i - 1])
            states[i] = one.follow(("trajectory",), 0, 1, samples).trajectory
            states[i, -1] = whole_orbit.section[i]
        steps = begin * samples + 1 + np.arange(count * samples)
        time = steps * (system.period / samples)
        return replace(whole_orbit, trajectory=states.reshape(count * samples, -1), time=time)


def orbit_of(
    archive: ArchiveView | str | os.PathLike[str],
    *,
    start: int | str = 0,
    record: Collection[str] | None = None,
    quiet: bool = False,
    **values: float,
) -> Orbit:
    """Return the orbit of a cell of a scan's archive, equal to that of the scan to the last bit.

    The orbit is computed again, over the transient and the periods of the scan; in a sweep, all
    cells before it are, too.  Without walls it is equal to round-off, if the scan recorded energies
    or peaks: the search for the largest ones ends steps of the motion.

    Parameters
    ----------
    archive : ArchiveView or path-like
        A scan.
    start : int or str
        The orbit of the cell, by number or name ("up", "random 3").
    record : collection of str, optional
        As in `simulate`; by default the section and, if there are walls, impacts.
    quiet : bool
        Hide the note that kernels are compiled.
    **values : float
        Each varied parameter, `omega=7.4, C=0.06`.  The nearest cell is used; its values are in the
        `system` of the orbit.

    Returns
    -------
    Orbit
        The section, impacts and other records, as `simulate` returns them.

    Raises
    ------
    RequestError
        For a missing parameter or one that did not vary, a value outside the scan, or an unknown
        start.
    IntegrationError
        If the orbit ends early, as it did in the scan.

    Examples
    --------
    >>> import nlds_vines as nv
    >>> scan = nv.scan("tmd", vary={"omega": {"values": [6.0]}}, record=["section"], quiet=True)
    >>> orbit = nv.orbit_of(scan, omega=6.0, quiet=True)
    >>> with scan.read() as results:
    ...     bool((orbit.section == results["section"][0, 0]).all())
    True
    """
    truth("quiet", quiet)
    return cell_orbit(archive, values, start).orbit(record, quiet)


def cell_orbit(
    archive: ArchiveView | str | os.PathLike[str], values: Mapping[str, float], start: int | str = 0
) -> CellOrbit:
    """Return the `CellOrbit` of a cell, not followed yet; arguments and errors as `orbit_of`."""
    if not isinstance(archive, ArchiveView):
        with read(archive) as view:
            return cell_orbit(view, values, start)
    from nlds_vines.engine.engine import engine_for

    scan = scan_of(archive)
    names, is_name = scan.start.names, isinstance(start, str) and not start.isdecimal()
    if is_name and start not in names:
        raise unknown("start", start, names[:20])
    number = int(start) if isinstance(start, str) and not is_name else start
    lane = names.index(start) if is_name else whole("start", number, 0, len(names) - 1)
    place, cells = nearest_place(archive.path, scan, values, scan.axes), scan.cells()
    label = str(archive["label"][(*place, lane)]) if "label" in archive else ""
    initial = scan.initial([np.array([i]) for i in place])
    (state,) = own_states(scan, cells[place].reshape(1), initial, np.array([lane]))
    engine, of_kernels = engine_for(system_at(scan, place)), cells.view(np.recarray)
    # an orbit of a sweep follows the cells before it, of which the first begins at rest
    first, *others = (*swept_before(scan, place, lane), place)
    begin = engine.begin_in(of_kernels[first], state, scan.method, scan.settings, scan.of)
    for cell in others:
        begin = begin.carried(scan.transient + scan.periods, of_kernels[cell])
    return CellOrbit(scan, begin, scan.start.names[lane], label)


def nearest_place(
    where: object, scan: Scan, values: Mapping[str, float], axes: Sequence[Axis]
) -> Place:
    """Return the place along `axes` that is nearest to `values`; `where` names the archive."""
    stated = {axis.name: axis for axis in axes}
    for name, ratio in ratios_in(scan.system.scene).items():  # as f in place of omega
        if name in values and ratio.gives in stated and stated.keys().isdisjoint(ratio.needs):
            unit = ratio.unit_of(scan.system.parameters)
            stated[ratio.gives] = Axis(name, stated[ratio.gives].values / unit)
    spans = {a.name: f"{a.values[0]:g} to {a.values[-1]:g}" for a in stated.values()}
    for name in values:
        if name not in spans:
            raise unknown(f"varied parameter of {where}:", name, spans)
    missing = [n for n, a in stated.items() if a.name not in values and a.values.size > 1]
    if missing:
        words = ", ".join(f"{name} from {span}" for name, span in spans.items())
        raise RequestError(f"{where} varies {words}: {', '.join(missing)} is missing")
    place = []
    for axis in stated.values():
        grid = axis.values
        value = number(axis.name, values.get(axis.name, grid[0]))
        edges = np.diff(grid[[0, 1, -2, -1]])[[0, 2]] / 2 if grid.size > 1 else np.zeros(2)
        # a cell extends halfway to the next
        slack = 1e-9 * max(abs(grid[0]), abs(grid[-1]))
        if not grid[0] - edges[0] - slack <= value <= grid[-1] + edges[1] + slack:
            span = spans[axis.name]
            raise RequestError(f"{axis.name} = {value!r} lies outside the scan: {span}")
        place.append(int(np.abs(grid - value).argmin()))
    return tuple(place)
