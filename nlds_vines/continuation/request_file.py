"""A continuation file (TOML), or what stands for one, read and checked."""

from __future__ import annotations

import os
from collections.abc import Collection, Mapping
from typing import Any

import numpy as np

from nlds_vines.continuation.request import Begin, Continuation
from nlds_vines.errors import RequestError, at, number, shown, table
from nlds_vines.model.axis import Interval
from nlds_vines.model.ratios import meant_by, ratios_in
from nlds_vines.model.request_layers import Document, Form, Layers
from nlds_vines.model.setting import checks
from nlds_vines.model.system import System
from nlds_vines.model.words import symbol_of, system_in_words

FORM = Form(
    kind="continuation",
    tables={
        "set": None,
        "along": None,
        "plane": None,
        **checks(Begin, Continuation),
    },
)
"""What may stand in a continuation file."""

DEFAULT_SYSTEM = "ssul-set6"
"""The system that is followed unless another one is named."""

DEFAULT_ALONG = {"omega": {"start": 5.0, "stop": 9.0}}
"""The parameter that is free unless another one is named."""


def load_continuation(
    source: str | os.PathLike[str] | Document | System | Continuation | None = None,
    changes: Document | None = None,
    changes_from: str = "changes",
) -> Continuation:
    """Return the continuation that a file means, checked throughout.

    Arguments:
        source: path of a TOML file (its name ends in `.toml`), a name of the catalog, the
            document as nested tables, a `System`, a `Continuation`, or None for SSul Set 6.
        changes: a document of the same form that overrides it entry by entry; `changes_from` names
            it in the message of an error.

    Raises `RequestError`, one line that names place, key, value and what is allowed.
    """
    if isinstance(source, Continuation) and not changes:
        return source
    given = DEFAULT_SYSTEM if source is None else source
    layers = Layers.of(FORM, given, changes, changes_from)
    system = layers.system_as_set(DEFAULT_SYSTEM)
    along, plane = _intervals(layers, system)
    title = layers.title(outdated_by=("system", "set", "along", "plane"))
    with at(layers.place("start")):
        begin = _begin(layers.table("start"))
    search = layers.values("search")
    with at(layers.holder("along").where):
        request = Continuation(
            title=_made_up_title(system, along) if title is None else title,
            system=system,
            along=along,
            begin=begin,
            plane=plane,
            **search,
        )
    return layers.told(request)


def _intervals(layers: Layers, system: System) -> tuple[Interval, Interval | None]:
    """Return the intervals that the uppermost tables `along` and `plane` mean."""
    holders = {key: layers.holder(key) for key in ("along", "plane")}
    free = meant_by(system.scene, [n for key, one in holders.items() for n in one.table(key)])
    free += system.following(free)
    found: dict[str, Interval] = {}
    for key, holder in holders.items():
        if entries := holder.table(key):
            with at(holder.place(key)):
                found[key] = _interval_of(key, in_parameters(entries, system, free))
    return found.get("along") or _interval_of("along", DEFAULT_ALONG), found.get("plane")


def in_parameters(
    entries: Document, system: System, free: Collection[str] = ()
) -> Mapping[str, Any]:
    """Return a table of an interval along a parameter in place of one along a ratio, as f [Hz].

    Arguments: the `entries` of the table; the `system` that its unit follows from; the names of
    all that is `free`.

    Raises `RequestError` where the unit follows from what is free, too.
    """
    known = ratios_in(system.scene)
    if len(entries) != 1 or not entries.keys() <= known.keys():
        return entries
    ((name, entry),) = entries.items()
    ratio = known[name]
    both = next((need for need in ratio.needs if need in free), None)
    if both is not None:
        raise RequestError(f"{name} follows from {both}, which is free, too: give {ratio.gives}")
    ends = {end: number(f"{end} of {name}", value) for end, value in table(name, entry).items()}
    ratio.what.check(np.array([*ends.values()]))
    unit = ratio.unit_of(system.parameters)
    return {ratio.gives: {end: value * unit for end, value in ends.items()}}


def _interval_of(key: str, entries: Document) -> Interval:
    if len(entries) != 1:
        raise RequestError(f"{', '.join(entries)} given; allowed: one parameter")
    ((name, entry),) = entries.items()
    found = table(name, entry, ("start", "stop"))
    if found.keys() != {"start", "stop"}:
        raise RequestError(f"{name} = {shown(dict(found))} must hold start and stop")
    return Interval(name, found["start"], found["stop"])


def _begin(entries: Document) -> Begin:
    """Return where branches begin: a label, or orbits, alone mean their policy."""
    meant = {"orbits": entries.get("states"), "label": entries.get("label")}
    policy = next((policy for policy, given in meant.items() if given), "rest")
    return Begin(**{"policy": policy, **entries})


def _made_up_title(system: System, along: Interval) -> str:
    return f"{system_in_words(system)}: branches along {symbol_of(along.name)}"
