"""From a tuning file, or what stands for one, to a checked `Tuning`."""

from __future__ import annotations

import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from nlds_vines.errors import RequestError, at, choice, shown, string, table
from nlds_vines.model.axis import Axis
from nlds_vines.model.catalogue import system_from
from nlds_vines.model.system import System
from nlds_vines.toml import read_toml
from nlds_vines.tuning.free_parameter import Free, tunable, usual
from nlds_vines.tuning.request import SAMPLED, SAMPLED_FREE, SECTIONS, Search, Surface, Tuning

DEFAULT_SYSTEM = "ssul-set6"
"""Whose structure, force and contact are taken where nobody says; its damper is not looked at."""

Document = Mapping[str, Any]


def load_tuning(
    source: str | os.PathLike[str] | Document | System | Tuning | None = None,
    changes: Document | None = None,
    changes_from: str = "changes",
) -> Tuning:
    """Return the tuning that a tuning file means, checked throughout.

    Arguments:
        source: path of a TOML file (its name ends in `.toml`), a name of the catalogue, the
            document as nested tables, a `System`, a `Tuning`, or None for SSul.
        changes: a document of the same form that overrides it entry by entry; what it sets is no
            longer free.  `changes_from` names it in the message of an error.

    Raises `RequestError`, one line that names place, key, value and what is allowed.
    """
    if isinstance(source, Tuning) and not changes:
        return source
    where, document = _open(source)
    below, above = _checked(where, document), _checked(changes_from, changes or {})
    system, free = _system_and_free(below, above, where, changes_from)
    with at(changes_from if "over" in above else where):
        over = tuple(Axis.of(*item) for item in _merged("over", below, above).items())
        return Tuning(
            title=_title(below, above, system, free, over),
            system=system,
            free=free,
            over=over,
            surface=_surface(_merged("surface", below, above)),
            search=Search(**_merged("search", below, above)),
            **_sampling(system, _merged("sampling", below, above)),
        )


def _open(source: object) -> tuple[str, Document]:
    """Return where a document comes from, and the document."""
    if source is None or isinstance(source, System):
        return "tuning", {"system": DEFAULT_SYSTEM if source is None else source}
    if isinstance(source, Tuning):
        return "tuning", source.document()
    if isinstance(source, Mapping):
        return "tuning", source
    if isinstance(source, str) and not source.endswith(".toml"):
        return "tuning", {"system": source}
    if isinstance(source, str | os.PathLike):
        return str(source), read_toml(Path(source))
    raise RequestError(f"tuning = {shown(source)} must be a path, a name, a table or a System")


def _checked(where: str, document: Document) -> Document:
    """Return a document whose tables have known keys."""
    with at(where):
        table("the tuning", document, ("title", "system", *SECTIONS))
        for key, known in SECTIONS.items():
            with at(f"[{key}]"):
                table(key, document.get(key, {}), known)
    return document


def _merged(key: str, below: Document, above: Document) -> dict[str, Any]:
    return {**below.get(key, {}), **above.get(key, {})}


def _system_and_free(
    below: Document, above: Document, where: str, changes_from: str
) -> tuple[System, tuple[Free, ...]]:
    """Return the system with what is set, and what is free: what is set is not, and conversely."""
    with at(changes_from if "system" in above else where):
        system = system_from(above.get("system", below.get("system", DEFAULT_SYSTEM)))
    for place, layer in ((where, below), (changes_from, above)):
        with at(place):
            _refuse_contradiction(layer)
            system = system.with_(**layer.get("set", {}))
    taken = above.get("set", {}).keys() | above.get("over", {}).keys()
    unset = [name for name in usual(system.scene) if name not in below.get("set", {})]
    entries: Document = below.get("free", {name: {} for name in unset})
    kept = {name: entry for name, entry in entries.items() if name not in taken}
    wanted = {**kept, **above.get("free", {})}
    with at(changes_from if "free" in above else where):
        for name in wanted:
            choice("free parameter", name, tunable(system.scene))
        in_order = [name for name in tunable(system.scene) if name in wanted]
        return system, tuple(Free.of(name, wanted[name]) for name in in_order)


def _refuse_contradiction(layer: Document) -> None:
    """Raise `RequestError` where one document both fixes a parameter and lets it go."""
    keys = ("set", "free", "over")
    for one, other in (keys[:2], keys[1:], keys[::2]):
        if both := sorted(layer.get(one, {}).keys() & layer.get(other, {}).keys()):
            raise RequestError(f"{both[0]} stands in [{one}] and in [{other}]: one of them only")


def _sampling(system: System, given: Document) -> Document:
    """Return the numbers of periods; of those sampled, as many as the scene needs by default."""
    return {"periods": SAMPLED if system.scene.walls else SAMPLED_FREE} | dict(given)


def _surface(entry: Document) -> Surface | None:
    """Return the surface that the table means; None where there is no table."""
    if not entry:
        return None
    names = entry.get("parameters")
    if not isinstance(names, list | tuple) or len(names) != 2:
        raise RequestError(f"parameters of the surface = {shown(names)} must be two names")
    return Surface(parameters=(names[0], names[1]), size=entry.get("size", Surface.size))


def _title(
    below: Document, above: Document, system: System, free: tuple[Free, ...], over: tuple[Axis, ...]
) -> str:
    """Return the title given, or one made from the tuning where none is or where it is outdated."""
    if "title" in above:
        return string("title", above["title"])
    if "title" in below and not above.keys() & {"system", "set", "free", "over"}:
        return string("title", below["title"])
    names = ", ".join(item.name for item in free)
    ranges = [f"{axis.name} from {axis.values[0]:g} to {axis.values[-1]:g}" for axis in over]
    omega = f"omega = {system.parameters['omega']:g}"
    if "omega" not in (axis.name for axis in over):
        ranges.insert(0, omega)
    return f"{system.scene.meaning.split(':')[0]}: {names} tuned for {', '.join(ranges)}"
