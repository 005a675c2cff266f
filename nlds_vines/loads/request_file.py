"""The request file of a response history (TOML), or what stands for one, read and checked."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from typing import Any

from nlds_vines.errors import MOST_CHARACTERS, RequestError, at, shown
from nlds_vines.loads.request import HistoryRequest, has, is_of_load
from nlds_vines.model.axis import Axis
from nlds_vines.model.catalog import as_system, load_system, system_from
from nlds_vines.model.loads.loading import ALL, Loading
from nlds_vines.model.ratios import meant_by
from nlds_vines.model.request_layers import Document, Form, Layer, Layers
from nlds_vines.model.setting import checks
from nlds_vines.model.system import System
from nlds_vines.model.words import system_in_words

FORM = Form(
    kind="response history",
    tables={"set": None, "vary": None, **checks(HistoryRequest, Loading)},
    lists=("systems",),
    sources="a path, a name, a System, a list of these, a table or a HistoryRequest",
)
"""What may stand in the request file of a response history."""

USUAL = ("none", "tmd", "ssbl", "ssul-set6")
"""What is compared unless systems are named: the structure alone, and the paper's dampers."""

Source = str | os.PathLike[str] | System | Sequence[Any] | Mapping[str, Any] | HistoryRequest | None
"""What may stand for a response history: systems or their names, a file, the document in one."""


def load_response_history(
    source: Source = None, changes: Document | None = None, changes_from: str = "changes"
) -> HistoryRequest:
    """Return the response history that a source means, checked throughout.

    Arguments:
        source: path of a TOML file, a system or its name, a list of these, the document in a file
            as nested tables, a `HistoryRequest`, or None for the paper's dampers.
        changes: a document of the same form that overrides it entry by entry; `changes_from` names
            it in the message of an error.

    Raises `RequestError`, one line that names place, key, value and what is allowed.
    """
    if isinstance(source, HistoryRequest) and not changes:
        return source
    given: Any = {"systems": list(USUAL)} if source is None else source
    if isinstance(given, Sequence) and not isinstance(given, str):
        given = {"systems": list(given)}
    layers = Layers.of(FORM, given, changes, changes_from)
    systems, axes = tuple(_systems(layers)), _axes(layers.holder("vary"))
    for layer in layers:
        for system in systems:
            _refuse_set_and_varied(layer, system)
    title = layers.title(outdated_by=("systems", "system", "set", "load", "vary", "start"))
    acts = layers.values("load")
    with at(layers.place("load")):
        load = Loading(**acts)
    values = {**layers.values("start"), **layers.values("sampling")}
    with at(layers.holder("load").where):
        made_up = title or _title(load, systems, axes)
        return layers.told(HistoryRequest(made_up, systems, load, axes, **values))


def _title(load: Loading, systems: Sequence[System], axes: Sequence[Axis]) -> str:
    """Return a title made of the load, the systems and what varies."""
    acts = "" if load == Loading() else load.words()
    varies = any(is_of_load(axis.name) for axis in axes)
    acts = acts[:1].upper() + acts[1:] if acts else "Blows" if varies else "Free decay"
    over = f", by {' and '.join(axis.name for axis in axes)}" if axes else ""
    return f"{acts}: {', '.join(map(system_in_words, systems))}{over}"[:MOST_CHARACTERS]


def _axes(layer: Layer) -> tuple[Axis, ...]:
    """Return the axes that `[vary]` means."""
    axes = []
    for name, entry in flattened(layer.table("vary")).items():
        with at(f"{layer.place('vary')} {name}"):
            axes.append(Axis.of(name, entry))
    return tuple(axes)


def flattened(entries: Mapping[str, Any]) -> dict[str, Any]:
    """Return entries by name; `friedlander.peak` may stand there as a table of a table, too."""
    found: dict[str, Any] = {}
    for name, entry in entries.items():
        if name in ALL and isinstance(entry, Mapping):
            found |= {f"{name}.{key}": value for key, value in entry.items()}
        else:
            found[name] = entry
    return found


def _systems(layers: Layers) -> list[System]:
    """Return the systems with the parameters set in both layers, the upper one last.

    A parameter that a system does not have is set for the others alone.
    """
    layer = layers.holder("systems")
    if not layer.document.get("systems"):
        layer = layers.holder("system")
        named: Any = [layer.document.get("system")]
    else:
        named = layer.document["systems"]
    with at(layer.where):
        if not isinstance(named, list | tuple):
            raise RequestError(f"systems = {shown(named)} must be a list of systems")
        found = [_system(one) for one in named]
    for layer in layers:
        settings = layer.table("set")
        with at(layer.place("set")):
            for name in settings:
                if not any(_takes(system, name) for system in found):
                    found[0].with_(**{name: settings[name]})  # which says what is allowed
            found = [
                system.with_(**{k: v for k, v in settings.items() if _takes(system, k)})
                for system in found
            ]
    return found


def _refuse_set_and_varied(layer: Layer, system: System) -> None:
    """Raise `RequestError` where a parameter stands in [set] and in [vary] of one layer."""
    names = {meant_by(system.scene, [name])[0]: name for name in layer.table("set")}
    for name in layer.table("vary"):
        (meant,) = meant_by(system.scene, [name])
        if meant in names:
            raise RequestError(
                f"{names[meant]} is set, and {name} varied by {layer.place('vary')}: not both"
            )


def _takes(system: System, name: str) -> bool:
    return has(system, name) or (name in ("law", "law_2") and bool(system.scene.walls))


def _system(source: Any) -> System:
    if isinstance(source, str) and source.endswith(".toml"):
        return as_system(source)
    return load_system(source) if isinstance(source, str) else system_from(source)
