"""A continuation file (TOML), or what stands for one, read and checked."""

from __future__ import annotations

import os

from nlds_vines.continuation.request import Begin, Continuation, Interval
from nlds_vines.errors import RequestError, at, shown, table, typed
from nlds_vines.model.layers import Document, Form, Layers
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


@typed
def load_continuation(
    source: str | os.PathLike[str] | Document | System | Continuation | None = None,
    changes: Document | None = None,
    changes_from: str = "changes",
) -> Continuation:
    """Return the continuation that a file means, checked throughout.

    Arguments:
        source: path of a TOML file (its name ends in `.toml`), a name of the catalogue, the
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
    along = _interval(layers, "along") or _interval_of("along", DEFAULT_ALONG)
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
            plane=_interval(layers, "plane"),
            **search,
        )
    return layers.told(request)


def _interval(layers: Layers, key: str) -> Interval | None:
    """Return the interval that the uppermost table of a key means; None where there is none."""
    holder = layers.holder(key)
    entries = holder.table(key)
    if not entries:
        return None
    with at(holder.place(key)):
        return _interval_of(key, entries)


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
