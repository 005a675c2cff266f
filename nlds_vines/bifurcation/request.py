"""A scan: one system, one or two varied parameters, where to start, how long, what to record.

`Scan.table` lists the datasets of its archive: those of `model.quantities` that are recorded.
Blocks are checked against this table, and the archive is written by it.
"""

from __future__ import annotations

import os
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import MISSING, dataclass, field
from functools import cache, cached_property, partial
from itertools import product
from math import prod
from typing import Any, ClassVar

import numpy as np

from nlds_vines.archives.archive import ArchiveView
from nlds_vines.archives.dataset import Dataset, Scale, Table
from nlds_vines.archives.files import parse_toml
from nlds_vines.archives.provenance import SCAN, Value
from nlds_vines.archives.representation import Rows
from nlds_vines.engine import records, solver_settings
from nlds_vines.engine.records import CAPTURE_FLAGS as CAPTURE
from nlds_vines.engine.spectrum import TAPERS, SpectralRecords, checked_signals
from nlds_vines.engine.starts import AT_ANY_PHASE, STATE, Start, starts_inside
from nlds_vines.errors import RequestError, at, checked_names, choice, string, unknown
from nlds_vines.model.axis import SAMPLE, Axis, Samples, sample_scale
from nlds_vines.model.catalog import any_system, looks_like_path, resource_text
from nlds_vines.model.labels import FLAGS, KEPT
from nlds_vines.model.parameters import (
    DESCRIBED,
    INITIAL,
    PARAMETERS,
    PHASE,
    component_of,
    symbol_of,
)
from nlds_vines.model.quantities import recorded
from nlds_vines.model.ratios import axes_of_parameters, meant_by, ratios_in, refuse_twice
from nlds_vines.model.scenes import Scene
from nlds_vines.model.setting import (
    Checked,
    Form,
    OneOf,
    Real,
    Request,
    Whole,
    check_settings,
    checked_changes,
    entries,
    is_given,
    setting,
)
from nlds_vines.model.system import System


def struck(scene: Scene) -> tuple[str, ...]:
    """Return the names of the bodies that a damper strikes; empty for fewer than two walls."""
    return scene.bodies_struck if len(scene.walls) > 1 else ()


def state_scales(count: int) -> Iterator[Scale]:
    """Yield the dimensions of multipliers, exponents and complex parts for `count` components."""
    yield Scale.counted("multiplier", count, "Floquet multiplier, the largest modulus first", 1)
    yield Scale.counted("exponent", count, "Lyapunov exponent, the largest first", 1)
    yield Scale("part", np.array(["real", "imaginary"]), "1", "part of a complex number")


OF = "displacement that is recorded; a-b: that of a minus that of b"
_FLAGS: Mapping[str, Mapping[str, int]] = {
    "regime": FLAGS,
    "spectra_agree": KEPT,
    "capture": CAPTURE,
    "status": records.STATUS_FLAGS,
}


def table_of(
    scene: Scene,
    want: Collection[str],
    axes: Sequence[Axis],
    start: Start,
    periods: int,
    spectral: SpectralRecords | None,
    of: Sequence[str] = (),
) -> Table:
    """Return the datasets of a scan that `want` asks for, and `status`."""
    dims, walls = (*(axis.name for axis in axes), "start"), struck(scene)
    absent = {name for name, there in (("wall", walls), ("damper", scene.dampers)) if not there}
    datasets: list[Dataset] = []
    for entry in recorded(scene, want):
        if entry.name != "start_state" or start.policy == "random":
            tail = tuple(dim for dim in entry.dims if dim not in absent)
            flags = _FLAGS.get(entry.name)
            if entry.name == "impact_wall":  # 0 is the near wall
                flags = {word.replace(" ", "_"): code for code, word in enumerate(scene.wall_words)}
            datasets.append(entry.dataset((*dims, *tail), scene, flags))
    # lengths are counted without making the values of dimensions
    size, touches = len(scene.components), records.touches_noted(want, scene, periods)
    lengths = {axis.name: axis.values.size for axis in axes}
    lengths |= {"start": start.orbits, "forcing_period": periods, "component": size}
    lengths |= {"impact": touches, "wall": len(walls), "damper": len(scene.dampers)}
    lengths |= {"displacement": len(of)}
    lengths |= {"multiplier": size, "exponent": size, "part": 2} if "evidence" in want else {}
    if spectral is not None:
        datasets = [spectral.in_units(dataset) for dataset in datasets]
        lengths |= spectral.lengths()
    return Table.of(datasets, {name: length for name, length in lengths.items() if length})


def begins_at_sections(view: ArchiveView) -> bool:
    """Return True if all orbits of a scan begin at phase zero, where the attractors' points lie."""
    start = parse_toml(view.text("scan"), "the attribute scan").get("start", {})
    return PHASE not in view.axes and not start.get(PHASE)


MOST_LANES = 10**8  # the most orbits of one scan: days of work on a large machine


def _for_experts(name: str, words: str) -> Any:
    """Return a setting that by default follows from the tolerance."""
    words += ", for experts, as [`nv.simulate`](python.md#options-of-simulate) takes them"
    return setting(None, Checked(solver_settings.FINENESS[name]), "sampling", words)


@dataclass(frozen=True, repr=False)
class Scan(Request):
    """A scan: what to compute; validated when made, immutable afterwards.

    Its other fields are the settings of a scan file (`docs/keys.md`).

    Parameters
    ----------
    title : str
        One line.
    system : System
        The parameters that do not vary [SI units].
    axes : tuple of Axis
        One or two varied parameters, or initial conditions; with `sampled` the numbers of samples.
    want : tuple of str
        The records; nothing else is computed, stored or compiled.
    start : Start
        The initial states of each cell's orbits.
    sampled : Samples, optional
        A table of parameters, one set a row, in place of axes.

    Raises
    ------
    RequestError
        If a field is invalid, or the system refuses a varied value.

    Examples
    --------
    >>> import nlds_vines as nv
    >>> scan = nv.load_scan("tmd", {"vary": {"omega": {"start": 5.0, "stop": 8.0, "num": 4}}})
    >>> scan.shape, scan.starts, scan.axes[0].values.tolist()
    ((4,), 1, [5.0, 6.0, 7.0, 8.0])
    """

    content: ClassVar[str] = SCAN

    title: str
    system: System
    axes: tuple[Axis, ...]
    want: tuple[str, ...] = setting(
        MISSING, Checked(records.checked_want, listed=True), "record",
        f"what is recorded, see [Datasets](datasets.md): of {', '.join(records.WANTS)}", "A,B,C",
        option="--record", usual=", ".join(records.USUAL),
    )  # fmt: skip
    start: Start = field(default_factory=Start)
    transient: int = setting(
        600, Whole(0), "sampling", "forcing periods that are discarded", "PERIODS"
    )
    periods: int = setting(120, Whole(1), "sampling", "forcing periods that are sampled", "PERIODS")
    method: str = solver_settings.method_setting()
    effort: str = setting(
        "standard", OneOf(solver_settings.EFFORTS), "sampling",
        "of a verdict: `quick`, `standard` or `thorough`, see [Labels](scans.md)", "EFFORT",
    )  # fmt: skip
    tolerance: float | str | None = solver_settings.tolerance_setting("sampling")
    signals: tuple[str, ...] = setting(
        (), Checked(checked_signals, listed=True), "spectrum",
        "what spectra are of: components of the state, u = x2 - x1, or of hosts roof, roof.v",
        usual="x1, u",
    )  # fmt: skip
    highest: float = setting(
        8.0, Real(0.0, 1000.0, inside=True), "spectrum",
        "multiple of the forcing frequency up to which a spectrum is kept",
    )  # fmt: skip
    window: str = setting(
        "hann", OneOf(TAPERS), "spectrum",
        f"of its amplitudes: {' or '.join(f'`{name}`' for name in TAPERS)}",
    )  # fmt: skip
    samples: int = setting(
        64, Whole(4, 4096), "spectrum", "states in each forcing period, for spectra"
    )
    nodes: int | None = _for_experts("nodes", "collocation nodes of a short impact")
    contact_steps: float | None = _for_experts("contact_steps", "steps of a contact")
    period_steps: float | None = _for_experts("period_steps", "steps of a period by `rk4`")
    sampled: Samples | None = None
    of: tuple[str, ...] = setting(
        (), Checked(partial(checked_names, "of"), listed=True), "record",
        "the displacements of a host whose `response` is recorded: a degree of freedom, a damper's "
        "mass, or a difference, `roof-floor2`", "A,B",
        option="--of", usual="degrees of freedom that dampers hang on",
    )  # fmt: skip

    def __post_init__(self) -> None:
        string("title", self.title)
        axes = tuple(self.axes)
        if self.sampled is not None:
            axes = (Axis(SAMPLE, np.arange(1.0, self.sampled.count + 1.0)),)
        object.__setattr__(self, "axes", axes)
        object.__setattr__(self, "system", self.system.with_axes(self.varied))
        check_settings(self)
        settings = self.settings
        if self.method == "exact":
            object.__setattr__(self, "tolerance", settings.tolerance)
        records.refuse_impossible(self.want, self.system.scene)
        self._check_axes()
        _ = self.spectral  # checks what spectra are of
        if records.ATTRACTOR in self.want and self.start.sweeps:
            raise RequestError(
                f"want {records.ATTRACTOR!r}: policy {self.start.policy!r} follows the orbits of "
                "other cells; allowed: rest, random:N, a state, or axes of initial conditions"
            )
        if self.sampled is not None and (records.ATTRACTOR in self.want or self.start.sweeps):
            what = f"want {records.ATTRACTOR!r}" if records.ATTRACTOR in self.want else "a sweep"
            raise RequestError(
                f"{what} follows attractors from cell to cell; samples have no order"
            )

    @property
    def varied(self) -> tuple[str, ...]:
        """The names of all parameters, ratios and initial conditions that vary."""
        names = tuple(axis.name for axis in self.axes)
        return names if self.sampled is None else self.sampled.names

    def _check_axes(self) -> None:
        names, scene, start = self.varied, self.system.scene, self.start
        refuse_twice(scene, names)
        settable, components = (*scene.allowed, *ratios_in(scene)), scene.components
        if start.state and len(start.state) != len(components):
            raise RequestError(
                f"state has {len(start.state)} numbers; kind {self.system.kind!r} has the "
                f"state {', '.join(components)}"
            )
        object.__setattr__(self, "of", self.system.displacements(list(self.of), self.want))
        choice("method", self.method, scene.methods)
        if self.nodes is not None and "nodes" not in scene.fineness:
            raise RequestError(f"nodes = {self.nodes}: impacts of {scene.meaning} have no nodes")
        varied = self.parameters if self.sampled is None else ()
        edges = [axis.values[[0, -1]].tolist() for axis in varied]
        corners = []
        for values in product(*edges):
            corners.append({axis.name: value for axis, value in zip(varied, values, strict=True)})
        self.system.refuse_corners(corners)
        if PHASE in names and start.phase:
            raise RequestError(f"phase is varied, and phase = {start.phase!r} given: choose")
        # any other name must be an initial condition; the system refuses parameters that its kind
        # lacks
        for name in (name for name in names if name not in settable and name not in PARAMETERS):
            allowed = (*components, PHASE)
            if name not in INITIAL or component_of(name) not in allowed:
                conditions = [*(f"{one}_0" for one in components), PHASE]
                kind = "axis" if self.sampled is None else "column"
                raise unknown(kind, name, [*settable, *conditions])
            if start.policy not in AT_ANY_PHASE:
                raise RequestError(
                    f"{name} is varied: orbits start at rest or in a given state, with this "
                    f"initial condition replaced; not with policy {start.policy!r}"
                )
        if self.sampled is not None:
            for name in {*names} & {*INITIAL}:
                INITIAL[name].check(self.sampled.columns[name])
            self.cells()
        elif not 1 <= len(names) <= 2 or len(set(names)) < len(names):
            raise RequestError(
                f"varied parameters: {', '.join(names) or 'none'}; allowed: one, or two different"
            )
        else:
            for axis in self.axes:
                if axis.name in INITIAL:
                    INITIAL[axis.name].check(axis.values[[0, -1]])
            # ranges are intervals, K is monotonic in each constant: the corners cover the grid
            self._grid([axis.values[[0, -1]] for axis in self.axes])
        cells = prod(self.shape)
        if self.lanes > MOST_LANES:
            sides = " x ".join(map(str, self.shape))
            words = f" = {cells} cells" if len(self.shape) > 1 else " cells"
            raise RequestError(
                f"the scan has {sides}{words}, {self.lanes} orbits; allowed: up to {MOST_LANES}"
            )

    def _grid(self, values: list[np.ndarray]) -> np.ndarray:
        """Return the cells of the grid for kernels, constant along axes of initial conditions."""
        varied = dict(zip((axis.name for axis in self.axes), np.ix_(*values), strict=True))
        varied = {name: value for name, value in varied.items() if name not in INITIAL}
        return np.broadcast_to(self.system.cells(varied), tuple(map(len, values)))

    @property
    def parameters(self) -> tuple[Axis, ...]:
        """The axes that are parameters of the system, in their order."""
        return tuple(axis for axis in self.axes if axis.name not in INITIAL)

    def initial(self, where: Sequence[np.ndarray]) -> dict[str, np.ndarray]:
        """Return the parts of the state and the phase, (n,) each, that axes set at places (n,)."""
        if self.sampled is not None:
            columns = self.sampled.columns.items()
            return {component_of(k): v[where[0]] for k, v in columns if k in INITIAL}
        return {
            component_of(axis.name): axis.values[places]
            for axis, places in zip(self.axes, where, strict=True)
            if axis.name in INITIAL
        }

    def starts_inside(self) -> list[str]:
        """Return a line that counts starts inside a wall; [] without any, and for random ones."""
        if self.start.policy == "random":
            return []
        if self.sampled is not None:
            places = dict(self.sampled.columns)
        else:
            values = {axis.name: axis.values for axis in self.axes}
            if self.start.sweeps:  # other cells begin where the orbit of the cell before ended
                last = self.axes[-1]
                ends = [0 if name == "up" else -1 for name in self.start.sweeps]
                values[last.name] = last.values[ends]
            places = dict(zip(values, np.ix_(*values.values()), strict=True))
        components = self.system.scene.components
        state: dict[str, Any] = dict(zip(components, self.start.state, strict=False))
        state |= {component_of(name): places[name] for name in places if name in INITIAL}
        shape = np.broadcast_shapes(*(part.shape for part in places.values()))
        return starts_inside(self.system, places, state, shape)

    def outline(self) -> Rows:
        """Return the system, the axes, the starts, and what is recorded."""
        yield "system", self.system.heading()
        starts = f"{self.starts} starts" if self.starts > 1 else "one start"
        axes = " x ".join(axis.heading() for axis in self.axes)
        if self.sampled is not None:
            axes = f"{self.sampled.count} samples of {', '.join(self.varied)}"
        yield "varied", f"{axes}; {starts} each ({self.start.policy}): {self.lanes} orbits"
        how = f"method {self.method}, effort {self.effort}"
        yield "periods", f"{self.transient} discarded, {self.periods} sampled; {how}"
        yield "recorded", ", ".join(self.want)

    @property
    def settings(self) -> solver_settings.Settings:
        """The solver settings: tolerance, nodes and steps."""
        return solver_settings.chosen_settings(
            self.method, {name: getattr(self, name) for name in solver_settings.FINENESS}
        )

    @property
    def shape(self) -> tuple[int, ...]:
        """Number of values along each axis."""
        return tuple(axis.values.size for axis in self.axes)

    @property
    def starts(self) -> int:
        """Number of orbits in each cell."""
        return self.start.orbits

    @property
    def lanes(self) -> int:
        """Number of orbits in all."""
        return prod(self.shape) * self.starts

    def cells(self) -> np.ndarray:
        """Return the numbers for kernels: an array of dtype `CELL` and shape `shape`."""
        if self.sampled is None:
            return self._grid([axis.values for axis in self.axes])
        columns = {k: v for k, v in self.sampled.columns.items() if k not in INITIAL}
        return np.broadcast_to(self.system.cells(columns), self.shape)

    @cached_property
    def spectral(self) -> SpectralRecords | None:
        """The records of spectra; None without any."""
        want = records.spectral(self.want)
        if not want:
            return None
        signals = self.system.recorded_signals(self.signals)
        sampling = self.periods, self.samples, self.highest, self.window
        return SpectralRecords(want, signals, *sampling)

    @property
    def scans(self) -> list[Scan]:
        """A list of this scan alone; `CurveRequest.scans` has several."""
        return [self]

    @cached_property
    def table(self) -> Table:
        """The datasets of its archive."""
        orbits = self.start, self.periods, self.spectral
        return table_of(self.system.scene, self.want, self.axes, *orbits, self.of)

    def scales(self) -> tuple[Scale, ...]:
        """Return the dimensions of its archive with their values."""
        scene, periods = self.system.scene, self.periods
        touches = records.touches_noted(self.want, scene, periods)
        cycle = "sampled forcing period, counted after the transient"
        impact = "impact after the transient, counted from the first"
        return (
            *(
                sample_scale(axis.values.size)
                if axis.name == SAMPLE
                else DESCRIBED[axis.name].scale(axis.values)
                for axis in self.axes
            ),
            Scale("start", np.array(self.start.names, np.str_), "1", "start of the orbit"),
            Scale.counted("forcing_period", periods, cycle, 1),
            Scale.counted("impact", touches, impact, 1),
            Scale("component", np.array(scene.components), "1", "component of the state"),
            *(
                Scale(dim, np.array(names), "1", words)
                for dim, names, words in (
                    ("damper", scene.dampers, "name of the damper"),
                    ("wall", struck(scene), "what is struck"),
                    ("displacement", self.of, OF),
                )
                if names
            ),
            *(state_scales(len(scene.components)) if "evidence" in self.want else ()),
            *(() if self.spectral is None else self.spectral.scales()),
        )

    def inputs(self) -> Iterator[tuple[Dataset, np.ndarray]]:
        """Yield the parameters of samples as datasets."""
        yield from () if self.sampled is None else self.sampled.contents()

    def document(self) -> dict[str, Any]:
        """Return the complete scan file, as nested tables with all parameters and axis values."""
        start: dict[str, Any] = {"policy": self.start.policy}
        if self.start.policy == "random":
            start |= {"count": self.start.count, "seed": self.start.seed}
        if self.start.state:
            start["state"] = list(self.start.state)
        if self.start.phase:
            start["phase"] = self.start.phase
        varied: dict[str, Any] = {}
        for axis in self.axes if self.sampled is None else ():
            varied |= axis.entry()
        if self.sampled is not None:
            varied = self.sampled.document()
        return {
            "title": self.title,
            "system": self.system.to_table(),
            "vary" if self.sampled is None else "samples": varied,
            "start": start,
            "sampling": entries(self, "sampling"),
            "record": {"want": list(self.want), **({"of": list(self.of)} if self.of else {})},
            **({"spectrum": entries(self, "spectrum")} if self.spectral else {}),
        }

    @property
    def about(self) -> dict[str, Value]:
        """The attributes of its archive beside the request itself: system, parameters, seed."""
        return {**self.system.attributes(self.varied), "seed": self.start.seed}


FORM = Form(
    "scan",
    (Start, Scan),
    whole=("vary", "samples"),
    systems=False,
    sources="a path, a name, a table, a System or a Scan",
)
"""The tables and keys of a scan file."""

DEFAULT_FILE = "figure8.toml"  # the packaged scan that is computed unless another one is given


def default_scan() -> dict[str, Any]:
    """Return the tables of the packaged scan, of which the caller may leave out some."""
    return dict(_default_tables())


@cache
def _default_tables() -> dict[str, Any]:
    return parse_toml(resource_text(DEFAULT_FILE), DEFAULT_FILE)


def load_scan(
    source: str | os.PathLike[str] | Mapping[str, Any] | Scan | System | None = None,
    changes: Mapping[str, Any] | None = None,
    changes_from: str = "changes",
) -> Scan:
    """Return the validated scan of a scan file, a system or a document.

    Parameters
    ----------
    source : path-like, mapping, Scan, System, str or None
        A TOML file, its document as nested tables, or a scan.  A system or its name means the
        default scan of that system, None the default scan (Figure 8).
    changes : mapping, optional
        A document of the same form that overrides the source entry by entry, and `vary` and
        `samples` as a whole.
    changes_from : str
        The name of the changes in messages of errors.

    Returns
    -------
    Scan
        The request, as `scan` takes it.

    Raises
    ------
    RequestError
        One line that names place, key, value and what is allowed.

    Examples
    --------
    >>> import nlds_vines as nv
    >>> nv.load_scan().title
    'Bifurcation diagram, SSul NES Set 6 (Figure 8)'
    """
    changes = checked_changes(changes, changes_from)
    if isinstance(source, Scan) and not changes:
        return source
    where = ""
    if isinstance(source, System) or (isinstance(source, str) and not looks_like_path(source)):
        changes = {"system": any_system(source), **changes}
        source = None
    if source is None:
        source, where = default_scan(), DEFAULT_FILE
        if is_given(changes.get("system")):
            del source["set"]  # what the default scan sets is meant for its own system
    request = FORM.read(source, changes, changes_from, where)
    sampled = request.samples()
    kind = "vary" if sampled is None else "samples"
    varied = request.table("vary") if sampled is None else sampled.columns
    system: Any = request.as_set(request.any_system(), dict.fromkeys(varied, kind))
    with at(request.place("start")):  # a state without a policy means the policy of that name
        entries_of_start = request.of(Start)
        policy = {"policy": STATE} if "state" in entries_of_start else {}
        start = Start(**policy | entries_of_start)
    axes = request.axes("vary") if sampled is None else ()
    # one file serves every system: records that a system lacks are left out
    with at(request.place("record")):
        asked = request.values.get("record", {}).get("want", records.USUAL)
        if not (want := records.possible_want(asked, system.scene)):
            records.refuse_impossible(asked, system.scene)
    with at(request.place("sampling")):
        sampling = request.values.get("sampling", {})
        solver_settings.chosen_settings(
            sampling.get("method", Scan.method),
            {name: sampling.get(name) for name in solver_settings.FINENESS},
        )
    with at(request.place("vary")):
        changing = meant_by(system.scene, [axis.name for axis in axes])
        changing += system.following(changing)
        axes = axes_of_parameters(axes, system.scene, system.parameters, changing)
    title = request.title("system", "set", "vary", "samples")
    if title is None:
        if sampled is None:
            names = [axis.name for axis in axes]
            symbols = ", ".join(symbol_of(axis.as_stated.name) for axis in axes)
        else:
            names = list(sampled.names)
            symbols = f"{sampled.count} samples of {', '.join(map(symbol_of, names))}"
        bare = system.with_axes(names)  # without a force, where the ground's motion varies
        words = [bare.in_words(), *request.set_in_words(bare, names)]
        title = f"{', '.join(words)}: {symbols}"
    return request.make(
        Scan,
        request.place(kind),
        **request.of(Scan) | {"want": want},
        title=title,
        system=system,
        axes=axes,
        start=start,
        sampled=sampled,
    )
