"""The request of a page of response curves: what to compute, and how each curve looks.

Every curve is a scan of its own along the same parameter, which is the frequency as a rule.
"""

from __future__ import annotations

import hashlib
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any, ClassVar

import numpy as np

from nlds_vines.archives.provenance import RESPONSE_CURVES, Value
from nlds_vines.bifurcation.request import Scan
from nlds_vines.errors import RequestError, at, checked_words, shown, string
from nlds_vines.model.catalog import catalog
from nlds_vines.model.quantities import BY_NAME, QUANTITIES
from nlds_vines.model.ratios import ratios_in
from nlds_vines.model.scenes import SCENES
from nlds_vines.model.setting import (
    Checked,
    Request,
    Truth,
    Whole,
    check_settings,
    entries,
    setting,
)
from nlds_vines.model.slow_manifold import SlowManifold, slow_manifold
from nlds_vines.model.system import System
from nlds_vines.model.words import setting_in_words, system_in_words
from nlds_vines.plotting.style import HUES

COLORS: Mapping[str, str] = HUES
"""Colors by name, those of Okabe and Ito; a request file may also write `#rrggbb`."""

MOST_COLUMNS = 4
"""Panels side by side: more of them are too narrow to read."""

LINES = ("solid", "dashed", "dashdot")
"""Kinds of line; a dotted one is the damper's energy."""

ALONE, ALONE_COLOR = "without damper", "#a8a8a8"
"""What a legend calls the curve of the structure alone, and its color, the palest in gray, too."""

CURVE_STARTS = ("rest", "up", "down", "both")
"""Where the orbits of a curve may begin; `both` draws two, and shades where they differ."""

ENERGY = "E1max"
"""What is drawn by default, and what a reduction below the curves is of."""

SHOWN = tuple(
    entry.name
    for entry in QUANTITIES
    if {"energy", "response"} & {*entry.record} and entry.dtype == "float64"
)
"""What may be drawn: the largest energies, and the numbers of a response."""


def records_of(shown: Collection[str]) -> tuple[str, ...]:
    """Return the words of `[record] want` that record what is shown, beside the energies."""
    words = {BY_NAME[name].record[0] for name in shown}
    return tuple(word for word in ("energy", "response") if word == "energy" or word in words)


_TURNS = tuple(
    COLORS[name] for name in ("vermillion", "blue", "green", "orange", "pink", "sky", "black")
)
"""Colors of curves for which none is asked, in this order."""


@dataclass(frozen=True)
class Curve:
    """One curve of a panel: what is computed, and how it looks.

    Arguments:
        scan: along one parameter.
        label: in the legend; empty for a label made from `settings` or from the system.
        settings: what panel and curve set, beyond what the whole page shares.
        color: as `#rrggbb`; `line`: of `LINES`.
        base: whether it is the one to look at, drawn stronger.
        shade: whether the panel shows where this one has impacts.
    """

    scan: Scan
    label: str = ""
    settings: Mapping[str, float] = field(default_factory=dict)
    color: str = "#000000"
    line: str = "solid"
    base: bool = False
    shade: bool = False

    @property
    def name(self) -> str:
        """The system, and whatever of it is not as in the catalog: `tmd_k2=2083_c2=112`."""
        return curve_name(self.scan)

    @property
    def manifold(self) -> SlowManifold | None:
        """The slow manifold of the system, if it has one."""
        try:
            return slow_manifold(self.scan.system)
        except RequestError:
            return None


@dataclass(frozen=True)
class Panel:
    """One frame of a page and the curves in it; `base` marks the frame of the tuning."""

    curves: tuple[Curve, ...]
    title: str = ""
    settings: Mapping[str, float] = field(default_factory=dict)
    base: bool = False


@dataclass(frozen=True, repr=False)
class CurvePage(Request):
    """A page of response curves; checked when made, immutable afterwards.

    Arguments:
        title: one line for people.
        panels: each with its curves.
        columns, damper_energy, reduction, log, manifold, show: as the fields say; a reduction, and
            several quantities, only of a single panel; the closed form only along omega and where
            a curve has one.

    Raises `RequestError` for curves that cannot stand on one page: along different parameters or
    values, with several starts, or without energies.
    """

    content: ClassVar[str] = RESPONSE_CURVES

    title: str
    panels: tuple[Panel, ...]
    columns: int = setting(1, Whole(1, MOST_COLUMNS), "figure", "panels side by side")
    damper_energy: bool = setting(
        False, Truth(), "figure", "draws E2max, too, dotted", option="--damper-energy"
    )
    reduction: bool = setting(
        False, Truth(), "figure", "draws the reduction by each damper below the curves"
    )
    log: bool = setting(
        False, Truth(), "figure", "draws what is shown on logarithmic axes", option="--log",
    )  # fmt: skip
    manifold: bool = setting(
        False, Truth(), "figure",
        "draws the 1:1 response in closed form of each free mass between two rigid walls",
        option="--manifold",
    )  # fmt: skip

    show: tuple[str, ...] = setting(
        (ENERGY,), Checked(lambda value: checked_words("show", value, SHOWN), listed=True),
        "figure", "what is drawn, a panel for each: the largest energies, or numbers of the "
        "response as x1_max, v1_rms, stroke_max, force_max, transmissibility, see "
        "[Datasets](datasets.md)",
        "A,B,C", usual=ENERGY,
        option="--show",
    )  # fmt: skip

    def __post_init__(self) -> None:
        """Check everything."""
        string("title", self.title)
        check_settings(self)
        if self.reduction and len(self.panels) > 1:
            raise RequestError("reduction = true needs a page of one panel: leave out [[panels]]")
        if len(self.show) > 1 and len(self.panels) > 1:
            raise RequestError("show: several quantities need a page of one panel")
        first = self.curves[0].scan
        for curve in self.curves:
            _refuse_unlike(curve.scan, first, self.show)
        self._check_show()
        if self.manifold:
            self._check_manifold()

    def _check_show(self) -> None:
        """Raise `RequestError` for what no curve records, as the force in a wall without one."""
        known = {name for curve in self.curves for name in curve.scan.table.datasets}
        for name in self.show:
            if name not in known:
                allowed = ", ".join(word for word in SHOWN if word in known)
                raise RequestError(f"show = {shown(name)}: no curve has it; allowed: {allowed}")

    def _check_manifold(self) -> None:
        """Raise `RequestError` where no curve has a closed form, or not along this axis."""
        if self.axis != "omega":
            raise RequestError(
                f"manifold = true needs curves along omega; these are along {self.axis}"
            )
        walled = [curve for curve in self.curves if curve.scan.system.scene.walls]
        if not walled:
            raise RequestError("manifold = true: no curve has walls")
        if not any(curve.manifold for curve in walled):
            with at("manifold = true"):
                slow_manifold(walled[0].scan.system)  # which says why it has none

    @property
    def body(self) -> str:
        """The word for the body that is forced: where curves differ in it, the structure."""
        bodies = {curve.scan.system.scene.body for curve in self.curves}
        return bodies.pop() if len(bodies) == 1 else "structure"

    @property
    def curves(self) -> tuple[Curve, ...]:
        """All curves, panel by panel."""
        return tuple(curve for panel in self.panels for curve in panel.curves)

    @property
    def places(self) -> Iterator[tuple[int, Curve]]:
        """Every curve with the number of its panel, from 0."""
        return ((i, curve) for i, panel in enumerate(self.panels) for curve in panel.curves)

    @property
    def axis(self) -> str:
        """The parameter along which the curves run."""
        return self.curves[0].scan.axes[0].name

    @property
    def values(self) -> np.ndarray:
        """Its values, (n,)."""
        return self.curves[0].scan.axes[0].values

    @property
    def several(self) -> bool:
        """Whether a page of one panel of curves shows several quantities, a panel for each."""
        return len(self.show) > 1

    @property
    def frames(self) -> list[tuple[int, str]]:
        """What each panel of the picture shows: the number of its curves' panel, a quantity."""
        if self.several:
            return [(0, name) for name in self.show]
        return [(place, self.show[0]) for place in range(len(self.panels))]

    @property
    def lanes(self) -> int:
        """Number of orbits in all."""
        return sum(curve.scan.lanes for curve in self.curves)

    @property
    def about(self) -> dict[str, Value]:
        """The attributes of its archive beside the request itself."""
        return {"along": self.axis}

    @cached_property
    def hash(self) -> str:
        """SHA-256 of what determines the numbers: those of the scans, and their panels."""
        text = "\n".join(f"{i} {curve.scan.hash}" for i, curve in self.places)
        return hashlib.sha256(text.encode()).hexdigest()

    def document(self) -> dict[str, Any]:
        """Return the request file that means exactly this page, complete, as nested tables."""
        most = max(self.curves, key=lambda curve: len(curve.scan.want))
        scan = most.scan.document()  # what a system cannot give is left out when this is read
        return {
            "title": self.title,
            **{key: scan[key] for key in ("vary", "start", "sampling", "record")},
            "figure": entries(self, "figure"),
            "panels": [
                {"title": panel.title, "set": dict(panel.settings), "base": panel.base}
                for panel in self.panels
            ],
            "curves": [self._entry(i, curve) for i, curve in self.places],
        }

    def _entry(self, place: int, curve: Curve) -> dict[str, Any]:
        """Return the table [[curves]] of a curve: its system as it is, and in which panel it is."""
        shared = self.panels[place].settings
        look = {name: getattr(curve, name) for name in ("label", "color", "line", "base", "shade")}
        own = {name: value for name, value in curve.settings.items() if name not in shared}
        return {**look, "panel": place + 1, "system": curve.scan.system.to_table(), "set": own}


def _refuse_unlike(scan: Scan, first: Scan, show: Sequence[str]) -> None:
    """Raise `RequestError` for a scan whose curve cannot stand beside that of the first."""
    (axis, *_), (other, *_) = scan.axes, first.axes
    if axis.name != other.name or not np.array_equal(axis.values, other.values):
        raise RequestError(f"curves along {other.name} and {axis.name}: give all the same values")
    if scan.start.policy not in CURVE_STARTS:
        raise RequestError(
            f"start = {shown(scan.start.policy)} begins {scan.starts} orbits at each value; "
            f"allowed: {', '.join(CURVE_STARTS)}"
        )
    for word in records_of(show):
        if word not in scan.want:
            raise RequestError(f"want = {shown(list(scan.want))} lacks {word}, which curves show")


def with_structure_alone(page: CurvePage) -> CurvePage:
    """Return a page with the curve of the structure alone in each panel, first.

    One that stands on the page already is not added, and a panel whose curves belong to different
    structures gets one for each.  A parameter that the structure alone lacks, k2 for instance,
    cannot be varied for it: such a page stays as it is.
    """
    there = {curve.scan.hash for curve in page.curves}
    panels = [replace(p, curves=(*_alone(p, there), *p.curves)) for p in page.panels]
    return replace(page, panels=tuple(panels))


def _alone(panel: Panel, there: Collection[str]) -> Iterator[Curve]:
    """Yield the curves of the structures alone of a panel, but for hashes that are `there`."""
    found: dict[str, tuple[Scan, Curve]] = {}
    for curve in panel.curves:
        scan = alone(curve.scan)
        if scan is not None and scan.hash not in there:
            found.setdefault(scan.hash, (scan, curve))
    for i, (scan, curve) in enumerate(found.values()):
        own = {k: v for k, v in curve.settings.items() if k in scan.system.parameters}
        words = [ALONE, *(setting_in_words(*item) for item in own.items() if len(found) > 1)]
        yield Curve(scan, ", ".join(words), own, ALONE_COLOR, LINES[i % len(LINES)])


def alone(scan: Scan) -> Scan | None:
    """Return the scan of the structure of a damper alone; None where there is no such structure."""
    allowed, parameters = SCENES["none"].allowed, scan.system.parameters
    if not scan.system.scene.damper or scan.axes[0].name not in allowed:
        return None
    values = {name: value for name, value in parameters.items() if name in allowed}
    title = catalog()["none"].title
    want = tuple(word for word in ("energy", "response") if word in scan.want)
    own = {*ratios_in(SCENES["none"])}
    ratios = {name: v for name, v in scan.system.fixed_ratios.items() if name in own}
    system = System("none", values, title=title, fixed_ratios=ratios)
    return replace(scan, title=title, system=system, want=want)


def label_of(curve: Curve) -> str:
    """Return what a curve is called: its label, what is set, or its system."""
    settings = ", ".join(setting_in_words(*item) for item in curve.settings.items())
    return curve.label or settings or system_in_words(curve.scan.system)


def turns(number: int) -> tuple[str, str]:
    """Return the color and the line of the curve of a number, from 0; after 21 they repeat.

    Neighbors differ in both, so that a gray print tells them apart, too.
    """
    return _TURNS[number % len(_TURNS)], LINES[number % len(LINES)]


def curve_name(scan: Scan) -> str:
    """Return the name of a scan's system, and what of it is not as in the catalog."""
    system = scan.system
    known = catalog()[system.name].parameters if system.name in catalog() else {}
    changed = {key: value for key, value in system.parameters.items() if known.get(key) != value}
    return "_".join([system.name, *(f"{key}={value:g}" for key, value in changed.items())])
