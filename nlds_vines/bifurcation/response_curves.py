"""Response curves: cases, each a scan along the same parameter, in one archive.

As a command: `nlds-vines response-curves`; in Python: `nv.response_curves(["tmd", "own.toml"])`.

The datasets of the archive are those of scans with a dimension `system`.  A request file is a scan
file with a table `[[curves]]` for each case.  With `[[panels]]` every case is drawn in every panel,
or in the panel that it names. A case or its panel, not both, may name the system; both may set
parameters, but not the same one.
"""

from __future__ import annotations

import hashlib
import os
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any, ClassVar

import numpy as np

from nlds_vines.archives.archive import ArchivePath, ArchiveView, read
from nlds_vines.archives.dataset import Dataset, Scale, Table
from nlds_vines.archives.provenance import RESPONSE_CURVES, Value
from nlds_vines.archives.representation import Outlined, Rows
from nlds_vines.bifurcation.request import FORM as SCAN_FORM
from nlds_vines.bifurcation.request import OF, Scan, load_scan
from nlds_vines.engine.records import USUAL
from nlds_vines.engine.starts import Start
from nlds_vines.errors import (
    RequestError,
    at,
    checked_words,
    is_command,
    shown,
    string,
    table,
    unknown,
    whole,
)
from nlds_vines.model.catalog import any_system, read_request, told_apart
from nlds_vines.model.parameters import (
    DESCRIBED,
    PARAMETERS,
    flat,
    range_in_words,
    setting_in_words,
)
from nlds_vines.model.quantities import BY_NAME, QUANTITIES
from nlds_vines.model.setting import (
    Checked,
    Document,
    Form,
    OneOf,
    Request,
    Text,
    Truth,
    Whole,
    check_settings,
    entries,
    is_given,
    setting,
)
from nlds_vines.model.slow_manifold import SlowManifold, free_mass_manifold
from nlds_vines.model.system import System
from nlds_vines.plotting.drawable import Drawable
from nlds_vines.plotting.palette import damper_colors
from nlds_vines.plotting.style import HUES

LINES = ("solid", "dashed", "dashdot")  # of curves; the damper's energy is dotted
ALONE = "without damper"
SYSTEM, WALL, PLACE, DAMPER = "system", "wall", "displacement", "damper"  # dimensions
DAMPERS = ("ssul-set6", "ssbl", "tmd")  # compared by default: those of the paper's Table 2
SAMPLING = {"transient": 600, "periods": 240}  # forcing periods: many, for irregular regimes
CURVE_STARTS = ("rest", "up", "down", "both")  # `both` gives two curves, shaded where they differ
ENERGY, REDUCTION = "E1max", "reduction"  # drawn by default

SHOWN = tuple(
    entry.name
    for entry in QUANTITIES
    if {"energy", "response"} & {*entry.record} and entry.dtype == "float64"
)
"""The quantities that can be drawn: the largest energies, and the response quantities.

Those of a displacement or one of several dampers of a host are named with it, `roof.x_max`."""

_OF_PLACES = frozenset(entry.name for entry in QUANTITIES if PLACE in entry.dims)

_DEFAULTS: Document = {
    "vary": {"omega": {"start": 4.5, "stop": 8.0, "num": 351}},
    "sampling": SAMPLING,
    "record": {"want": ["impacts", "energy"]},
    "figure": {"reduction": True},
}
_HEX = re.compile(r"#[0-9a-f]{6}")
_SYSTEM = Checked(lambda system: system)  # the scan validates it, together with the parameters


def _color(value: object) -> str:
    if isinstance(value, str) and (value in HUES or _HEX.fullmatch(value)):
        return HUES.get(value, value)
    raise unknown("color", value, [*HUES, "#rrggbb"])


def _in_words(settings: Mapping[str, Any] | None) -> str:
    return ", ".join(setting_in_words(*item) for item in flat(settings or {}).items())


def _checked_show(value: object) -> tuple[str, ...]:
    """Return the words of `show`; whether a host has the displacement of one, its scan checks."""
    words = () if isinstance(value, str) or not isinstance(value, Sequence) else value
    of_hosts = [one for one in words if isinstance(one, str) and _quantity(one) in SHOWN]
    return checked_words("show", value, dict.fromkeys([*SHOWN, *of_hosts]))


def _quantity(shown: str) -> str:
    return shown.rpartition(".")[2]


_TAILS = ((), (WALL,), (PLACE,), (DAMPER,))  # dimensions of a number after `start`


def numbers_of_orbits(scan: Scan) -> dict[str, Dataset]:
    """Return the datasets of a scan with one value for each orbit, wall, displacement or damper."""
    datasets = scan.table.datasets.items()
    return {name: entry for name, entry in datasets if entry.tail in _TAILS}


def dampers_of(scan: Scan) -> tuple[str, ...]:
    """Return the names of dampers that own numbers; the damper of a kind has no name."""
    return scan.system.owning_dampers


@dataclass(frozen=True)
class Panel:
    """A panel of the picture; `base` marks its title as the original tuning."""

    title: str = setting("", Text(), "[panels]", "heading above it")
    system: Any = setting(None, _SYSTEM, "[panels]", "of all its curves")
    settings: Mapping[str, Any] | None = setting(
        None, table, "[panels]", "parameters of all its curves", key="set"
    )
    base: bool = setting(
        False, Truth(), "[panels]", "whether its title is marked as the original tuning"
    )

    @property
    def words(self) -> str:
        return self.title or _in_words(self.settings)


@dataclass(frozen=True, repr=False)
class Case(Outlined):
    """A curve of the picture; once its file is read, it has its `scan` and its `panel`."""

    label: str = setting(
        "", Text(), "[curves]", "in the legend", usual="what it sets, or its system"
    )
    system: Any = setting(None, _SYSTEM, "[curves]", "its system", usual="the panel's")
    settings: Mapping[str, Any] | None = setting(
        None, table, "[curves]", "its parameters", key="set"
    )
    base: bool = setting(False, Truth(), "[curves]", "whether it is drawn stronger")
    color: str = setting(
        HUES["black"], Checked(_color), "[curves]",
        f"{', '.join(f'`{name}`' for name in HUES)} or `#rrggbb`", usual="black",
    )  # fmt: skip
    line: str = setting("solid", OneOf(LINES), "[curves]", ", ".join(f"`{name}`" for name in LINES))
    shade: bool = setting(
        False, Truth(), "[curves]", "whether the panel is shaded where it has impacts"
    )
    panel: int | None = setting(
        None, Whole(1), "[curves]", "number of the only panel that has it, from 1"
    )
    scan: Scan = None  # type: ignore[assignment]  # an entry of a file has none yet

    @property
    def title(self) -> str:
        return self.label or _in_words(self.settings) or self.scan.system.in_words()

    @property
    def manifold(self) -> SlowManifold | None:
        try:
            return free_mass_manifold(self.scan.system)
        except RequestError:
            return None


@dataclass(frozen=True, repr=False)
class CurveRequest(Request):
    """Response curves of several cases; checked when made, immutable afterwards."""

    content: ClassVar[str] = RESPONSE_CURVES

    title: str
    cases: tuple[Case, ...]
    panels: tuple[Panel, ...] = (Panel(),)
    columns: int = setting(1, Whole(1, 4), "figure", "panels side by side")
    damper_energy: bool = setting(
        False, Truth(), "figure", "draws E2max, too, dotted", option="--damper-energy"
    )
    reduction: bool = setting(
        False, Truth(), "figure", "draws the reduction by each damper below the curves"
    )
    log: bool = setting(
        False, Truth(), "figure", "draws what is shown on a logarithmic ordinate", option="--log",
    )  # fmt: skip
    manifold: bool = setting(
        False, Truth(), "figure",
        "draws the 1:1 response in closed form of each free mass between two rigid walls",
        option="--manifold",
    )  # fmt: skip
    show: tuple[str, ...] = setting(
        (ENERGY,), Checked(_checked_show, listed=True),
        "figure", "what is drawn, a panel for each: the largest energies, or response "
        "quantities such as x1_max, v1_rms, stroke_max, force_max, transmissibility, of a host "
        "`roof.x_max`, see [Datasets](datasets.md)",
        "A,B,C", usual=ENERGY,
        option="--show",
    )  # fmt: skip

    def __post_init__(self) -> None:
        string("title", self.title)
        check_settings(self)
        if self.reduction and len(self.panels) > 1:
            raise RequestError("reduction = true needs one panel: leave out [[panels]]")
        if len(self.show) > 1 and len(self.panels) > 1:
            raise RequestError("show: several quantities need one panel")
        for case in self.cases:
            (axis, *_), start = case.scan.axes, case.scan.start
            if axis.name != self.axis or not np.array_equal(axis.values, self.values):
                both = " and ".join(dict.fromkeys((self.axis, axis.name)))
                text = f"curves along {both}: all need the same parameter and values"
                raise RequestError(text)
            if start.policy not in CURVE_STARTS:
                raise RequestError(
                    f"start = {shown(start.policy)} begins {start.orbits} orbits at each value; "
                    f"allowed: {', '.join(CURVE_STARTS)}"
                )
        if len(different := {case.scan.of for case in self.cases if case.scan.of}) > 1:
            text = " and of ".join(", ".join(of) for of in sorted(different))
            raise RequestError(f"curves record the response of {text}: all need the same `of`")
        recorded = self.recorded
        for name in self.show:
            if name not in recorded:
                allowed = ", ".join(word for word in recorded if _quantity(word) in SHOWN)
                raise RequestError(f"show = {shown(name)}: no curve has it; allowed: {allowed}")
        if not self.manifold:
            return
        with at("manifold = true"):
            if self.axis != "omega":
                raise RequestError(f"needs curves along omega; these are along {self.axis}")
            walled = [case for case in self.cases if case.scan.system.scene.walls]
            if not walled:
                raise RequestError("no curve has walls")
            if not any(case.manifold for case in walled):
                free_mass_manifold(walled[0].scan.system)  # raises the reason

    @property
    def axis(self) -> str:
        return self.cases[0].scan.axes[0].name

    @property
    def values(self) -> np.ndarray:
        return self.cases[0].scan.axes[0].values

    @cached_property
    def names(self) -> tuple[str, ...]:
        """A unique name for each case: its title and, with several panels, that of its panel."""
        names: list[str] = []
        for case in self.cases:
            words = {case.title: None, self.panels[(case.panel or 1) - 1].words: None}
            names.append(", ".join(filter(None, words)))
        numbers = [names[:i].count(name) + 1 for i, name in enumerate(names)]
        pairs = zip(names, numbers, strict=True)
        return tuple(name if number == 1 else f"{name} [{number}]" for name, number in pairs)

    @property
    def body(self) -> str:
        """The word for the body that is forced: the structure, if the cases differ in it."""
        bodies = {case.scan.system.scene.body for case in self.cases}
        return bodies.pop() if len(bodies) == 1 else "structure"

    def starts_inside(self) -> list[str]:
        pairs = zip(self.names, self.cases, strict=True)
        return [f"{name}: {line}" for name, case in pairs for line in case.scan.starts_inside()]

    @property
    def lanes(self) -> int:
        return sum(case.scan.lanes for case in self.cases)

    @property
    def about(self) -> dict[str, Value]:
        return {"along": self.axis, "content": self.content}

    @property
    def scans(self) -> list[Scan]:
        return [case.scan for case in self.cases]

    @cached_property
    def dampers(self) -> tuple[str, ...]:
        """The names of the dampers along the dimension `damper`, if a host has several."""
        several = any(scan.system.scene.dampers for scan in self.scans)
        names = dict.fromkeys(name for scan in self.scans for name in dampers_of(scan))
        return tuple(names) if several else ()

    @cached_property
    def table(self) -> Table:
        """The `numbers_of_orbits` of all scans.

        If kinds have a number, too, hosts do not have it for each damper: the damper of a kind has
        no name.
        """
        datasets: dict[str, Dataset] = {}
        kinds = [scan for scan in self.scans if not dampers_of(scan)]
        of_kinds = {name for scan in kinds for name in numbers_of_orbits(scan)}
        for scan in sorted(self.scans, key=lambda scan: not scan.system.scene.damper):
            for name, entry in numbers_of_orbits(scan).items():
                if DAMPER in entry.tail and name in of_kinds:
                    continue
                dims, former = (SYSTEM, *entry.dims), datasets.get(name)
                if former is None or len(dims) > len(former.dims):
                    datasets[name] = replace(entry, dims=dims)
        return Table(datasets, {scale.name: scale.values.size for scale in self.scales()})

    @property
    def recorded(self) -> tuple[str, ...]:
        """The names by which the numbers of the `table` are shown."""
        places = next((scan.of for scan in self.scans if scan.of), ())
        names = {PLACE: places, DAMPER: self.dampers}
        recorded: list[str] = []
        for name, entry in self.table.datasets.items():
            along = names.get(entry.tail[0]) if entry.tail else None
            recorded += [name] if along is None else [f"{one}.{name}" for one in along]
        return tuple(recorded)

    def put(self, scan: Scan, name: str, array: np.ndarray, into: np.ndarray) -> None:
        """Write the numbers (..., starts, own tail) of a scan to those of the `table`, in place."""
        tail, own = self.table.datasets[name].tail, numbers_of_orbits(scan)[name].tail
        if DAMPER in tail:
            places = [self.dampers.index(one) for one in dampers_of(scan)]
            into[..., places] = array if own else array[..., np.newaxis]
        elif WALL in tail and not own:
            into[..., 0] = array
        elif DAMPER not in own:
            into[...] = array

    def scales(self) -> list[Scale]:
        starts = np.array(self.scans[0].start.names, dtype=np.str_)
        dampers = [Scale(DAMPER, np.array(self.dampers), "1", "name of the damper")]
        return [
            Scale(SYSTEM, np.array(self.names), "1", "damper, or the structure alone"),
            DESCRIBED[self.axis].scale(self.values),
            Scale("start", starts, "1", "start of the orbit"),
            Scale(WALL, np.array(["near", "far"]), "1", "wall that is struck"),
            *(Scale(PLACE, np.array(of), "1", OF) for of in {scan.of for scan in self.scans} if of),
            *(dampers if self.dampers else []),
        ]

    def inputs(self) -> Iterator[tuple[Dataset, np.ndarray]]:
        systems = [scan.system for scan in self.scans]
        names, kinds = [one.name for one in systems], [one.kind for one in systems]
        yield Dataset.text("system_name", (SYSTEM,), "name of the system"), np.array(names, object)
        yield Dataset.text("kind", (SYSTEM,), "kind of damper"), np.array(kinds, object)
        for name in dict.fromkeys(
            [*PARAMETERS, *(key for one in systems for key in one.parameters)]
        ):
            values = np.array([one.parameters.get(name, np.nan) for one in systems])
            if name != self.axis and not np.isnan(values).all():
                yield DESCRIBED[name].dataset((SYSTEM,)), values

    @cached_property
    def hash(self) -> str:
        """SHA-256 of what determines the numbers: the scans and the names of the cases."""
        pairs = zip(self.cases, self.names, strict=True)
        text = "\n".join(f"{case.scan.hash} {name}" for case, name in pairs)
        return hashlib.sha256(text.encode()).hexdigest()

    def document(self) -> dict[str, Any]:
        """Return the complete request file, which gives this request again, as nested tables."""
        # records and displacements that a system lacks are left out when this is read
        most = max(self.scans, key=lambda scan: (bool(scan.of), len(scan.want)))
        scan = most.document()
        words = dict.fromkeys(word for one in (most, *self.scans) for word in one.want)
        scan["record"]["want"] = list(words)
        return {
            "title": self.title,
            **{key: scan[key] for key in ("vary", "start", "sampling", "record")},
            "figure": entries(self, "figure"),
            "panels": [entries(panel, "[panels]") for panel in self.panels],
            "curves": [
                entries(case, "[curves]") | {"system": case.scan.system.to_table()}
                for case in self.cases
            ],
        }


# ---- from a file, a document or systems ----------------------------------------------------------

FORM = Form(
    "response curves",
    (Start, Scan, CurveRequest),
    whole=("vary",),
    rows={"panels": Panel, "curves": Case},
    systems=False,
    sources="a path, a table or a CurveRequest",
)
"""The tables and keys of a request file of response curves: those of a scan, and more."""

Source = str | os.PathLike[str] | System | Sequence[Any] | Mapping[str, Any] | CurveRequest | None
"""What may stand for a request: systems or their names, a file, the document in one."""


def curves_from(source: Source, changes: Document, where: str) -> CurveRequest:
    """Return the request of a source; for systems, with each structure alone before them."""
    systems: Any = changes.get("systems", ())
    changes = {key: value for key, value in changes.items() if key != "systems"}
    is_document = isinstance(source, CurveRequest | Mapping)
    document: Any = source if is_document else _DEFAULTS
    if isinstance(source, str | os.PathLike) and str(source).endswith(".toml"):
        written = read_request(source)
        document, is_document = source, "curves" in written
        if not is_document:  # the curve of its system, along what it varies, sampled as it says
            changes = _completed(written, changes)
    if not is_document and not is_given(systems):
        listed = source if isinstance(source, list | tuple) else [source]
        systems = DAMPERS if source is None else listed
    if is_given(systems):
        if isinstance(systems, str) or not isinstance(systems, Sequence):
            raise RequestError(f"{where}: systems = {shown(systems)} must be a list of systems")
        with at("--system" if is_command() else where):
            made = [
                any_system(str(one) if isinstance(one, os.PathLike) else one) for one in systems
            ]
        colors, rows = damper_colors([system.name for system in made]), []
        labels = told_apart(made)
        for i, (system, color, label) in enumerate(zip(made, colors, labels, strict=True)):
            line = LINES[i % len(LINES)] if system.scene.damper else "solid"
            rows.append({"system": system, "label": label, "color": color, "line": line})
        changes |= {"curves": rows, "panels": [{}]}
    request = load_curves(document, changes, where)
    if not is_document and "title" not in changes:
        settings = changes.get("set", {}).items()
        words = [setting_in_words(*item) for item in settings if item[0] in PARAMETERS]
        title = ["Response curves", *words, range_in_words(request.axis, request.values)]
        request = replace(request, title=", ".join(title))
    return with_structure_alone(request) if systems else request


def _completed(written: Document, changes: Document) -> dict[str, Any]:
    """Return changes with the usual tables and keys that a file without curves does not have."""
    completed = dict(changes)
    for name, usual in _DEFAULTS.items():
        if name in ("vary", "record"):
            if name not in written:
                completed.setdefault(name, usual)
            continue
        own = written.get(name, {})
        missing = {key: value for key, value in usual.items() if key not in own}
        completed[name] = {**missing, **changes.get(name, {})}
    return completed


def load_curves(
    source: str | os.PathLike[str] | Mapping[str, Any] | CurveRequest,
    changes: Document | None = None,
    changes_from: str = "changes",
) -> CurveRequest:
    """Return the validated request of a TOML file or document, which `changes` override."""
    document = FORM.read(source, changes, changes_from)
    look = document.of(CurveRequest)
    keys = (key for key in SCAN_FORM.keys if key != "title")
    shared = {key: document.document[key] for key in keys if key in document.document}
    want = shared.get("record", {}).get("want", USUAL)
    if isinstance(want, Sequence) and not isinstance(want, str):  # else the scan refuses it
        show = look.get("show", ())
        needed = ["energy", *(BY_NAME[_quantity(name)].record[0] for name in show)]
        want = list(dict.fromkeys([*want, *needed]))
        of = [name.rpartition(".")[0] for name in show if _quantity(name) in _OF_PLACES]
        if any(of):
            places = [*dict.fromkeys(place for place in of if place)]
            shared["record"] = {"of": places, **shared.get("record", {})}
    shared["record"] = {**shared.get("record", {}), "want": want}
    panels, rows = document.rows("panels") or [Panel()], document.rows("curves")
    cases: list[Case] = []
    # of displacements that a system lacks: whether it is a kind, its place, and the error
    refusals: list[tuple[bool, int, RequestError]] = []
    with at(document.origin("curves")):
        for number, panel in enumerate(panels, start=1):
            hashes: set[str] = set()
            for place, row in enumerate(rows, start=1):
                with at(f"[[curves]] {place}"):
                    if whole("panel", row.panel or number, 1, len(panels)) != number:
                        continue
                    if panel.system is not None and row.system is not None:
                        text = "system is named by [[panels]] as well: name it in one of the two"
                        raise RequestError(text)
                    of_panel, of_case = panel.settings or {}, row.settings or {}
                    if both := sorted(of_panel.keys() & of_case.keys()):
                        text = f"{both[0]} is set by [[panels]] as well: set it in one of the two"
                        raise RequestError(text)
                    systems = (panel.system, row.system, shared.get("system"))
                    system = next((one for one in systems if one is not None), None)
                    settings = {**shared.get("set", {}), **of_panel, **of_case}
                    scan, refusal = _scan_of({**shared, "system": system, "set": settings})
                    if refusal is not None:
                        is_kind = "response" in scan.want
                        refusals.append((is_kind, place, refusal))
                    if len(scan.axes) != 1:
                        raise RequestError(f"{len(scan.axes)} parameters are varied; allowed: one")
                    case = replace(row, panel=number, settings=of_case, scan=scan, system=None)
                    if scan.hash in hashes:
                        raise RequestError(f"{case.title} stands twice in one panel")
                hashes.add(scan.hash)
                cases.append(case)
            if not hashes:
                raise RequestError(f"[[panels]] {number} has no curve")
        if refusals and not any(case.scan.of for case in cases):
            _, place, refusal = min(refusals, key=lambda one: one[:2])  # that of a host first
            with at(f"[[curves]] {place}"):
                raise refusal
    usual = "response curves" if document.left is None else Path(document.layers[0][0]).stem
    return document.make(
        CurveRequest,
        document.origin("curves"),
        title=document.title() or usual,
        cases=tuple(cases),
        panels=tuple(replace(panel, system=None) for panel in panels),
        **look,
    )


def _scan_of(given: Document) -> tuple[Scan, RequestError | None]:
    """Return the scan of a case, and the refusal if its system lacks the displacements of `of`.

    A host then records no response, as the structure alone does; a kind has its own response.
    """
    try:
        return load_scan(given), None
    except RequestError as refusal:
        if "of" not in given["record"]:
            raise
        record = {key: value for key, value in given["record"].items() if key != "of"}
        scan = load_scan({**given, "record": record})
        if scan.of:
            want = tuple(word for word in scan.want if word != "response")
            scan = replace(scan, want=want, of=())
        return scan, refusal


def _has(system: System, displacements: Sequence[str]) -> bool:
    """Return False if one of the displacements is that of a damper that the system lacks."""
    try:
        system.displacements(displacements)
    except RequestError:
        return False
    return True


def with_structure_alone(request: CurveRequest) -> CurveRequest:
    """Return a request of one panel with each structure alone before the dampers."""
    there, alone = {case.scan.hash for case in request.cases}, dict[str, Scan]()
    for scan in (case.scan for case in request.cases if case.scan.system.scene.damper):
        bare = scan.system.alone()
        if request.axis in bare.scene.allowed:
            of = scan.of if _has(bare, scan.of) else ()
            has = ("energy", "response") if of == scan.of else ("energy",)
            want = tuple(word for word in has if word in scan.want)
            scan = replace(scan, title=bare.heading(), system=bare, want=want, of=of)
            if scan.hash not in there:
                alone[scan.hash] = scan
    cases = [
        Case(ALONE, None, {}, color=HUES["gray"], line=LINES[i % len(LINES)], panel=1, scan=scan)
        for i, scan in enumerate(alone.values())
    ]
    return replace(request, cases=(*cases, *request.cases))


# ---- results -------------------------------------------------------------------------------------


@dataclass(frozen=True, repr=False)
class ResponseCurve(Outlined):
    """The results along the curve of one case."""

    name: str  # of the case
    case: Case  # its scan, and the look of its curve
    # (n, starts) by quantity; of two walls the larger value; of a host `roof.x_max`, and of several
    # dampers `ball.impulse_max`
    numbers: Mapping[str, np.ndarray]
    alone: np.ndarray | None = None  # (n,) E1max of the structure alone, if there is a damper

    def outline(self) -> Rows:
        return [("recorded", ", ".join(self.numbers))]

    @property
    def values(self) -> np.ndarray:
        """The parameter along the curve, (n,)."""
        return self.case.scan.axes[0].values

    def __getitem__(self, name: str) -> np.ndarray:
        """Return a recorded quantity (n,) of the first start; `RequestError` for another name."""
        if name not in self.numbers:
            allowed = ", ".join(self.numbers)
            raise RequestError(f"{shown(name)} is not recorded along curves; allowed: {allowed}")
        return self.numbers[name][:, 0]

    @property
    def E1max(self) -> np.ndarray:
        """Largest energies of the structure [J], (n,)."""
        return self["E1max"]

    @property
    def peak(self) -> float:
        """The highest E1max, of all starts [J]; NaN if none is finite."""
        return float(np.fmax.reduce(self.numbers["E1max"], axis=None))

    @property
    def peak_at(self) -> float:
        highest = np.fmax.reduce(self.numbers["E1max"], axis=1)
        return float(self.values[np.nanargmax(highest)]) if np.isfinite(self.peak) else np.nan

    @property
    def peak_reduction(self) -> float:
        """1 - peak / peak of the structure alone; NaN without a damper."""
        highest = np.nan if self.alone is None else float(self.alone.max())
        return 1.0 - self.peak / highest if highest else np.nan

    @property
    def failed(self) -> int:
        return int(np.count_nonzero(self.numbers["status"] > 0)) if "status" in self.numbers else 0

    def cycles(self, start: int = 0) -> np.ndarray:
        """Return "n,k" for each orbit nT,k, "" for another one; an empty array if not recorded."""
        n, k = (self.numbers.get(name) for name in ("periodicity", "impact_count"))
        if n is None or k is None:
            return np.empty(0, dtype=np.str_)
        if (k < 0).all() and not self.case.scan.system.scene.walls:
            return np.empty(0, dtype=np.str_)
        pairs = zip(n[:, start], k[:, start], strict=True)
        return np.array(
            [f"{periods},{impacts}" if periods > 0 else "" for periods, impacts in pairs]
        )


@dataclass(frozen=True, repr=False)
class ResponseCurves(Drawable):
    """The response curves in an archive.

    Attributes
    ----------
    path : ArchivePath
    request : CurveRequest
        The request; computed again, it gives the same numbers.
    curves : tuple of ResponseCurve
        The results of each case, in the order of `request.cases`; by name:
        `results["TMD"]` on this object.
    """

    drawn_by = "nlds_vines.bifurcation.picture.curves"

    path: ArchivePath
    request: CurveRequest
    curves: tuple[ResponseCurve, ...]

    @property
    def failed(self) -> int:
        """Number of orbits that failed."""
        return sum(curve.failed for curve in self.curves)

    def __getitem__(self, name: str) -> ResponseCurve:
        """Return the curve of a case; `RequestError` for another name."""
        for curve in self.curves:
            if curve.name == name:
                return curve
        allowed = ", ".join(curve.name for curve in self.curves)
        raise RequestError(f"case = {shown(name)} is not there; allowed: {allowed}")

    def lines(self) -> Iterator[str]:
        """Yield the title and a line for each curve: its peak, and the reduction of the peak."""
        yield self.request.title
        axis = self.request.cases[0].scan.axes[0]
        stated = axis.as_stated  # f [Hz] in place of omega, if the request has it
        unit, factor = DESCRIBED[stated.name].unit, stated.values[-1] / axis.values[-1]
        for curve in self.curves:
            at = factor * curve.peak_at
            text = f"{curve.name}: peak {curve.peak:.5g} J at {stated.name} = {at:g}"
            text += f" {unit}" if unit != "1" else ""
            if np.isfinite(curve.peak_reduction):
                lower = "lower" if curve.peak_reduction >= 0 else "higher"
                percent = 100 * abs(curve.peak_reduction)
                text += f", {percent:.1f} % {lower} than that of the structure alone"
            yield text + (f"; {curve.failed} orbits failed" if curve.failed else "")


def curves_in(path: str | os.PathLike[str]) -> ResponseCurves:
    with read(path) as view:
        return curves_of(view)


def curves_of(view: ArchiveView) -> ResponseCurves:
    """Return the response curves in an open archive; `RequestError` for another archive."""
    request = view.request(RESPONSE_CURVES, load_curves)
    dims = (SYSTEM, request.axis, "start")
    curves = []
    for i, (name, case) in enumerate(zip(request.names, request.cases, strict=True)):
        numbers: dict[str, np.ndarray] = {}
        for key in (key for key in view.names if view.dims(key)[:3] == dims):
            values, tail = view[key][i], view.dims(key)[3:]
            if tail and tail[0] in (PLACE, DAMPER):
                names = view[tail[0]]
                numbers |= {f"{one}.{key}": values[..., j] for j, one in enumerate(names)}
            else:
                numbers[key] = np.fmax.reduce(values, axis=-1) if tail else values
        curves.append(ResponseCurve(name, case, numbers))
    for i, curve in enumerate(curves):
        alone = _energy_alone(curve.case.scan, curves)
        numbers = dict(curve.numbers)
        if alone is not None and REDUCTION not in numbers:  # of a host
            numbers[REDUCTION] = 1.0 - numbers[ENERGY] / alone[:, np.newaxis]
        curves[i] = replace(curve, numbers=numbers, alone=alone)
    return ResponseCurves(ArchivePath.of(view.path), request, tuple(curves))


def _energy_alone(scan: Scan, curves: Sequence[ResponseCurve]) -> np.ndarray | None:
    """Return E1max (n,) of the structure alone: in closed form, of a host along its own curve."""
    system: System = scan.system
    if not system.scene.damper:
        return None
    in_closed_form = system.energy_alone(scan.cells())
    if in_closed_form is not None:
        return in_closed_form
    bare = _without_words(system.alone())
    for curve in curves:
        other = curve.case.scan.system
        if not other.scene.damper and _without_words(other) == bare:
            return curve.E1max
    return None


def _without_words(system: System) -> dict[str, Any]:
    """Return the table of a system without its name, its title and the sources of its numbers."""
    values = system.to_table()
    return {key: values[key] for key in values if key not in ("name", "title", "sources")}
