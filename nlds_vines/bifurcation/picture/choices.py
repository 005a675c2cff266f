"""What a picture of a scan can show: recorded quantities, in all cells or along one parameter.

Any numeric dataset of a scan, one or several values for each orbit, can be drawn unless its entries
differ in unit or meaning: a new dataset needs nothing here.  A choice is checked before anything is
computed, and before an archive is drawn.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from nlds_vines.archives.archive import ArchiveView
from nlds_vines.archives.dataset import Dataset
from nlds_vines.archives.provenance import SCAN
from nlds_vines.bifurcation.request import load_scan
from nlds_vines.engine.records import ATTRACTOR
from nlds_vines.engine.solver_settings import most_watched
from nlds_vines.errors import RequestError, unknown
from nlds_vines.model.labels import CHAOS
from nlds_vines.model.quantities import COORDINATES, MAPS, STRUCTURE, drawn_in, stored_in
from nlds_vines.model.signals import is_velocity
from nlds_vines.plotting.bands import drawable, is_list
from nlds_vines.plotting.style import body_of, quantity_label, setting_label, signal_symbol

SIGNAL = "signal"  # the dimension along which spectral quantities differ in their signal
PARTS = ("damper", "displacement")  # those along which quantities of hosts differ in the part
SECTION = "section"  # the dataset whose components are quantities of their own
_NO_NUMBERS = ("component", "part")  # dimensions along which units or meanings differ


@dataclass(frozen=True)
class DrawnQuantity:
    name: str  # the word of `--show`: a dataset, or a component of the section
    dataset: str
    units: str
    long_name: str
    fill: float  # the value of orbits that have none
    single: bool  # whether an orbit has one numeric value of it; False for codes
    index: Mapping[str, int] = field(default_factory=dict)  # places in the dataset, by dimension
    body: str = STRUCTURE  # the word for the body that is forced
    coded: bool = False  # whether its values are codes of words, which only maps show

    @property
    def label(self) -> str:
        name = self.name
        if SIGNAL in self.index:
            name = f"{self.dataset}:{signal_symbol(name.split(':')[1])}"
        return quantity_label(name, self.units, self.long_name, self.body)

    def of(self, view: ArchiveView, at: Mapping[str, int] | None = None) -> np.ndarray:
        """Return its values (..., starts, values per orbit), NaN if missing; `at` fixes axes."""
        places = {**self.index, **(at or {})}
        array = view.take(self.dataset, **places)
        dims = [dim for dim in view.dims(self.dataset) if dim not in places]
        array = array.reshape((*array.shape[: dims.index("start") + 1], -1))
        return drawable(np.where(array == self.fill, np.nan, array))


def quantities(
    datasets: Iterable[Dataset],
    components: Sequence[str],
    signals: Sequence[str] = (),
    *parts: Sequence[str],
) -> dict[str, DrawnQuantity]:
    """Return the drawable quantities of datasets by name.

    There is one for each component, for each signal, and for each name along `PARTS`.
    """
    by_name: dict[str, DrawnQuantity] = {}
    for entry in datasets:
        if entry.name == SECTION:
            for i, name in enumerate(components):
                unit, body = entry.units.split(", ")[i % 2], name.removeprefix("v_")
                words = f"{('displacement', 'velocity')[i % 2]} of {body}, {entry.long_name}"
                about = unit, words, np.nan, False
                by_name[name] = DrawnQuantity(name, SECTION, *about, index={"component": i})
        elif SIGNAL in entry.dims:  # a quantity for each signal, `broadband:x1`
            units, single = entry.units.split(", "), entry.tail == (SIGNAL,)
            for i, signal in enumerate(signals):
                unit = units[0] if len(units) == 1 else "m/s" if is_velocity(signal) else "m"
                about = unit, f"{entry.long_name.split(';')[0]}, {signal}", np.nan, single
                name = f"{entry.name}:{signal}"
                by_name[name] = DrawnQuantity(name, entry.name, *about, index={SIGNAL: i})
        elif (dims := {*PARTS} & {*entry.dims}) and "start" in entry.dims:
            (dim,), is_single = dims, entry.tail == (*dims,)
            for i, part in enumerate(parts[PARTS.index(dim)]):
                about = entry.units, entry.long_name, float(entry.fill), is_single
                name = f"{part}.{entry.name}"
                by_name[name] = DrawnQuantity(name, entry.name, *about, index={dim: i})
        elif entry.dtype != "str" and "start" in entry.dims:
            is_code = entry.flags is not None
            if not (entry.tail if is_code else {*_NO_NUMBERS} & {*entry.tail}):
                about = entry.units, entry.long_name, float(entry.fill), not (is_code or entry.tail)
                by_name[entry.name] = DrawnQuantity(entry.name, entry.name, *about, coded=is_code)
    return by_name


def quantities_in(view: ArchiveView) -> dict[str, DrawnQuantity]:
    names = ("component", SIGNAL, *PARTS)
    dims = (list(view[name]) if name in view else [] for name in names)
    by_name = quantities(map(view.describe, view.names), *dims)
    body = body_of(view.attrs.get("kind"))
    return {name: replace(quantity, body=body) for name, quantity in by_name.items()}


@dataclass(frozen=True)
class Slice:
    """The cells of a scan along one parameter, the other being constant."""

    view: ArchiveView
    axis: str  # the parameter on the abscissa
    at: Mapping[str, int] = field(default_factory=dict)  # name and index of the constant parameter

    @property
    def values(self) -> np.ndarray:
        return self.view[self.axis]

    @property
    def starts(self) -> list[str]:
        return list(self.view["start"])

    @property
    def constant_setting(self) -> str:
        """The value of the parameter that is constant, in LaTeX; empty if there is none."""
        pairs = ((name, float(self.view[name][place])) for name, place in self.at.items())
        return ", ".join(setting_label(*pair) for pair in pairs)

    def of(self, quantity: DrawnQuantity) -> np.ndarray:
        return quantity.of(self.view, self.at)

    def labels(self) -> np.ndarray | None:
        return self.view.take("label", **self.at) if "label" in self.view else None

    def violated(self) -> np.ndarray:
        return violated_in(self.view, self.at)


def violated_in(view: ArchiveView, at: Mapping[str, int] | None = None) -> np.ndarray:
    """Return a mask (axes, starts) of the orbits that pass the limit of their scene."""
    if "violations" not in view:
        return np.zeros(view.take("status", **(at or {})).shape, dtype=bool)
    return np.asarray(view.take("violations", **(at or {})) > 0)


REGIMES, COEXISTING, SHARES, SHARE = "regimes", "coexisting", "shares", "share:"
BASINS = "basins"  # the choices beside numbers; `SHARE` is followed by a label, as in `share:T,0`
LOG, LINEAR = SCALES = "log:", "linear:"  # prefixes of a quantity in a map: the scale of its colors
NUMBERS = drawn_in(MAPS)  # a map shows the first that is recorded; any other on request

GROUPS = ("displacement", "velocity", "energy")
"""Words for several quantities of a diagram."""


def group(word: str, drawn: Mapping[str, DrawnQuantity]) -> list[str]:
    """Return the quantities that a word of `GROUPS` means: those of the damper first."""
    if word == "energy":
        datasets = [entry.name for entry in stored_in("energy")]
        return [name for name, quantity in drawn.items() if quantity.dataset in datasets]
    of_section = [name for name, quantity in drawn.items() if quantity.dataset == SECTION]
    return of_section[::2][::-1] if word == "displacement" else of_section[1::2][::-1]


def usual_places(view: ArchiveView, drawn: Mapping[str, DrawnQuantity]) -> list[str]:
    """Return the displacements of a usual diagram: of many, a damper and what it hangs on."""
    places = group("displacement", drawn)
    if len(places) <= 2:
        return places
    dampers = [name for name in places[::-1] if f"{name}.attached_to" in view.attrs]
    first = dampers[:1] or places[:1]
    ends = [str(view.attrs.get(f"{name}.attached_to")) for name in first]
    return [*first, *(name for name in ends if name in places)]


_OF_SEVERAL_STARTS = (COEXISTING, SHARES)


def is_map(values: Sequence[np.ndarray]) -> bool:
    """Return True if a scan with these values of its axes is drawn as a map, not as curves."""
    return len(values) == 2 and not any(map(is_list, values))


def usual_show(recorded: Mapping[str, DrawnQuantity], labeled: bool) -> str | None:
    if labeled:
        return REGIMES
    return next(iter(drawn_by(MAPS, recorded)), None)


def drawn_by(place: str, recorded: Mapping[str, DrawnQuantity]) -> list[str]:
    """Return the recorded quantities that are drawn at a place of `model.quantities`, in order."""
    return [
        name
        for dataset in drawn_in(place)
        for name, quantity in recorded.items()
        if quantity.dataset == dataset
    ]


def scale_and_quantity(show: str) -> tuple[str, str]:
    """Split `log:E1max` into one of `SCALES`, or an empty string, and the name of a quantity."""
    scale = next((word for word in SCALES if show.startswith(word)), "")
    return scale, show.removeprefix(scale)


def rows_of(show: str, drawn: Mapping[str, DrawnQuantity]) -> list[str]:
    """Return the quantities of a diagram from the top: `x1,energy` gives x1, E1max and E2max."""
    rows: list[str] = []
    for word in filter(None, (piece.strip() for piece in show.split(","))):
        names = group(word, drawn) if word in GROUPS else []
        rows += [name for name in names or [word] if name != REGIMES]
    numbers = [name for name, quantity in drawn.items() if not quantity.coded]
    for name in rows:
        if name not in numbers:
            raise _not_recorded(name, [REGIMES, *GROUPS, *numbers])
    return list(dict.fromkeys(rows))


def check_show(
    show: str,
    values: Sequence[np.ndarray],
    starts: int,
    drawn: Mapping[str, DrawnQuantity],
    labeled: bool,
) -> None:
    """Raise `RequestError` unless the picture of a scan over such axes can show `show`."""
    if show == BASINS:
        if ATTRACTOR not in drawn:
            raise RequestError(f"show = {show!r} needs attractors: scan with --record {ATTRACTOR}")
        return
    needs_labels = show in (REGIMES, *_OF_SEVERAL_STARTS) or show.startswith(SHARE)
    if needs_labels and not labeled:
        raise RequestError(f"show = {show!r} needs regimes: scan with regime in --record")
    if not is_map(values):
        if show in _OF_SEVERAL_STARTS or show.startswith(SHARE):
            raise RequestError(f"show = {show!r} is for maps: vary two parameters over ranges")
        rows_of(show, drawn)
        return
    is_share = show.startswith(SHARE) and len(show) > len(SHARE)
    if (is_share or show in _OF_SEVERAL_STARTS) and starts < 2:
        raise RequestError(f"show = {show!r} needs several starts: random:N or both")
    scale, name = scale_and_quantity(show)
    numbers = [n for n, one in drawn.items() if one.single or (one.coded and not scale)]
    if not (is_share or show in (REGIMES, *_OF_SEVERAL_STARTS) or name in numbers):
        others = [] if scale else [REGIMES, *_OF_SEVERAL_STARTS, f"{SHARE}LABEL"]
        raise _not_recorded(name, [*others, *numbers])


def _not_recorded(show: str, allowed: Sequence[str]) -> RequestError:
    if show in (*NUMBERS, *GROUPS, *COORDINATES):
        return RequestError(f"show = {show!r} is not recorded; there are: {', '.join(allowed)}")
    return unknown("show", show, allowed)


EXCEEDANCE = "exceedance"  # the panel `E1max:exceedance`: the share of samples above each value
_USUAL_PANELS = 8  # of samples: two of the first quantity alone, the others against columns


def sample_panels(
    recorded: Mapping[str, DrawnQuantity], columns: Sequence[str], labeled: bool
) -> dict[str, str]:
    """Return the panels that samples can fill, with their descriptions."""
    numbers = {name: one for name, one in recorded.items() if one.single}
    first = [name for name in NUMBERS if name in numbers]
    panels = {}
    for name in dict.fromkeys([*first, *numbers]):
        words = numbers[name].long_name
        panels[name] = f"histogram of {words}"
        panels[f"{name}:{EXCEEDANCE}"] = f"share of samples above each value of {words}"
        panels |= {f"{name}:{column}": f"{words} against {column}" for column in columns}
    return panels | ({REGIMES: "share of samples in each final regime"} if labeled else {})


def usual_sample_panels(panels: Mapping[str, str]) -> list[str]:
    """Return the default panels of samples: those of the first quantity, and the regimes."""
    first = next(iter(panels), "")
    chosen = [name for name in panels if name == first or name.startswith(f"{first}:")]
    return chosen[:_USUAL_PANELS] + [REGIMES] * (REGIMES in panels and first != REGIMES)


def in_legend(label: str, view: ArchiveView) -> str:
    """Return the text of a label in a legend: chaos with the forcing periods it was watched for."""
    if label != CHAOS:
        return label
    scan = view.request(SCAN, load_scan)
    return f"{label} (for {most_watched(scan.transient, scan.periods, scan.effort)} T)"
