"""The request file of a portrait (TOML), or what stands for one, read and checked."""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import TYPE_CHECKING, Any

from nlds_vines.errors import RequestError, at, checked_state, choice, shown
from nlds_vines.model.request_layers import Form, Layer, Layers
from nlds_vines.model.setting import (
    Checked,
    OneOf,
    ParameterTable,
    Text,
    Whole,
    checks,
    reader,
    setting,
    settings_of,
)
from nlds_vines.model.system import System
from nlds_vines.model.words import system_in_words
from nlds_vines.orbits.solver_settings import laid_over
from nlds_vines.portrait.request import (
    SYSTEM,
    Column,
    PortraitRequest,
    Window,
    checked_panels,
    checked_window,
    described,
)

if TYPE_CHECKING:
    from nlds_vines.bifurcation.cell_orbit import CellOrbit


def _checked_windows(value: object) -> list[Window]:
    """Return the windows of one run, in the order of time."""
    if not isinstance(value, Sequence) or isinstance(value, str) or not value:
        raise RequestError(f"windows = {shown(value)} must be a list of pairs [begin, end]")
    found = [checked_window("windows", pair) for pair in value]
    for first, second in pairwise(found):
        if second.begin < first.end:
            raise RequestError(
                f"windows {first.begin}:{first.end} and {second.begin}:{second.end} "
                "must follow each other in time"
            )
    return found


_LENGTHS = ("transient", "periods")  # in place of which windows may be given


@dataclass(frozen=True)
class Times:
    """Where orbits of a portrait begin, and which of their periods are looked at."""

    policy: str = setting("rest", OneOf(("rest",)), "start", "`rest`")
    state: Any = setting(
        (), Checked(lambda value: value), "start", "x1, v1, x2, v2 at t = 0 [m, m/s]"
    )
    transient: int = setting(
        600, Whole(0), "sampling", "forcing periods that are discarded", "PERIODS"
    )
    periods: int = setting(240, Whole(1), "sampling", "forcing periods that are sampled", "PERIODS")
    windows: Any = setting(
        (), Checked(_checked_windows, listed=True), "sampling",
        "`[[begin, end], ...]`: periods to look at, in place of `transient` and `periods`",
        "B:E,B:E",
    )  # fmt: skip


@dataclass(frozen=True)
class ColumnEntry:
    """A column of the page in a file."""

    name: str = setting("", Text(), "[column]", "what stands above it")
    settings: Mapping[str, Any] | None = setting(
        None, ParameterTable(), "[column]", "parameters of it", key="set"
    )
    window: Window | None = setting(
        None, Checked(lambda value: checked_window("window", value)), "[column]",
        "`[begin, end]`: the periods that it shows", usual="those of `[sampling]`",
    )  # fmt: skip
    panels: tuple[str, ...] = setting(
        (), Checked(checked_panels, listed=True), "[column]", "of the page, which it fills",
        usual="all",
    )  # fmt: skip


FORM = Form(
    kind="portrait",
    tables={"set": None, **checks(Times, PortraitRequest)},
    rows={"column": reader(ColumnEntry)},
)
"""What may stand in the request file of a portrait."""

_OF_RUN = tuple(settings_of(PortraitRequest, "sampling"))


def load_portrait(
    source: str | os.PathLike[str] | Mapping[str, Any] | System | None = None,
    changes: Mapping[str, Any] | None = None,
    changes_from: str = "changes",
) -> PortraitRequest:
    """Return the request that a source means, checked throughout.

    Arguments:
        source: path of a TOML file (.toml), name of a system, the document in a file as nested
            tables, a `System`, or None for SSul NES Set 6 as it stands in the catalog.
        changes: a document of the same form that overrides it entry by entry; `changes_from` names
            it in the message of an error.

    Raises `RequestError`, one line that names place, key, value and what is allowed.
    """
    layers = Layers.of(FORM, SYSTEM if source is None else source, changes, changes_from)
    for layer in layers:
        _refuse_both(layer)
    columns = tuple(_columns(layers))
    title = layers.title(outdated_by=("system", "set"))
    sampling = laid_over(*(layer.values("sampling") for layer in layers))
    look = layers.values("portrait")
    start = _start(layers)
    with at(layers.below.where):
        request = PortraitRequest(
            _made_up_title(columns) if title is None else title,
            columns,
            start=start,
            **{name: sampling[name] for name in _OF_RUN if name in sampling},
            **look,
        )
    return layers.told(request)


def portrait_of(
    cell: CellOrbit, changes: Mapping[str, Any], changes_from: str = "changes"
) -> PortraitRequest:
    """Return the request for the orbit of an archive's cell, by default over the scan's periods.

    Arguments: the `cell`; `changes`, a document as `load_portrait` takes it, without a system, a
    start and a method, which are the cell's.

    Raises `RequestError` as `load_portrait`.
    """
    scan, system = cell.scan, cell.begin.system
    for key in ("system", "set", "start"):
        if changes.get(key):
            raise RequestError(f"{changes_from}: {key} beside an archive, which holds it")
    for key in ("method", "tolerance"):
        if key in changes.get("sampling", {}):
            raise RequestError(f"{changes_from}: {key} beside an archive, which holds it")
    start = f", start {cell.start}" if scan.starts > 1 else ""
    regime = f"; in the scan: {cell.label}" if cell.label else ""
    usual = {"transient": scan.transient, "periods": scan.periods, "method": scan.method}
    document = {"title": described(system) + start + regime, "system": system, "sampling": usual}
    return replace(load_portrait(document, changes, changes_from), cell=cell)


def _refuse_both(layer: Layer) -> None:
    """Raise `RequestError` where windows stand beside what they replace, in one table."""
    sampling = layer.table("sampling")
    if "windows" in sampling and sampling.keys() & set(_LENGTHS):
        raise RequestError(
            f"{layer.place('sampling')}: windows beside transient or periods: "
            "give windows, or the other two"
        )


def _columns(layers: Layers) -> Iterator[Column]:
    """Yield the columns: each of [[column]], in each of the windows or in its own."""
    system, windows = layers.system(), _windows(layers)
    asked = layers.above.table("sampling").keys() & {"windows", *_LENGTHS}
    chosen = "panels" in layers.above.table("portrait")
    for entry in layers.below.rows("column") or [ColumnEntry()]:
        seen = windows if asked or entry.window is None else [entry.window]
        panels = () if chosen else entry.panels
        with at(layers.below.where):
            one = system.with_(**{**layers.below.table("set"), **(entry.settings or {})})
        with at(layers.above.place("set")):
            one = one.with_(**layers.above.table("set"))
        yield from (Column(one, window, entry.name, panels) for window in seen)


def _windows(layers: Layers) -> list[Window]:
    """Return the windows of a run; transient and periods above replace windows below."""
    sampling = layers.values("sampling")
    if "windows" in sampling and not layers.above.table("sampling").keys() & set(_LENGTHS):
        return list(sampling["windows"])
    transient = sampling.get("transient", Times.transient)
    return [Window(transient, transient + sampling.get("periods", Times.periods))]


def _start(layers: Layers) -> tuple[float, ...] | None:
    """Return the state at t = 0, None for rest; a start above replaces the one below."""
    layer = layers.holder("start")
    entry = layer.table("start")
    with at(layer.place("start")):
        if "state" not in entry:
            choice("policy", entry.get("policy", "rest"), ("rest",))
            return None
        if "policy" in entry:
            raise RequestError("policy beside state: give one of them")
        return checked_state(entry["state"])


def _made_up_title(columns: Sequence[Column]) -> str:
    """Return a title made of the system, or of its name alone where the columns differ."""
    system = columns[0].system
    same = all(column.system == system for column in columns)
    return described(system) if same else system_in_words(system)
