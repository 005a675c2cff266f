"""A scan file (TOML) read, checked, and laid over by what the command line changes."""

from __future__ import annotations

import os
from collections.abc import Collection, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from nlds_vines.bifurcation.request import _SAMPLING, Scan
from nlds_vines.errors import RequestError, at, shown, string, table
from nlds_vines.model.axis import Axis
from nlds_vines.model.catalogue import FILE_KEYS, system_from
from nlds_vines.model.scenes import Scene
from nlds_vines.model.system import System, refuse_contradiction
from nlds_vines.orbits.starts import Start
from nlds_vines.orbits.wants import checked_want, possible_want, refuse_impossible
from nlds_vines.packaged_files import resource_text
from nlds_vines.toml import parse_toml, read_toml

_KEYS: Mapping[str, tuple[str, ...] | None] = {
    "set": None,  # the system knows which parameters it has
    "vary": None,
    "start": ("policy", "count", "seed"),
    "sampling": tuple(_SAMPLING),
    "record": ("want",),
}
_USUAL_WANT = ("section", "impacts", "energy", "regime")


def load_scan(
    source: str | os.PathLike[str] | Mapping[str, Any] | Scan | None = None,
    changes: Mapping[str, Any] | None = None,
    changes_from: str = "changes",
) -> Scan:
    """Return the scan that a scan file means, checked throughout.

    Arguments:
        source: path of a TOML file, the document in it as nested tables, a `Scan`, or None for
            the embedded default (Figure 8).
        changes: a document of the same form that overrides it entry by entry, though `vary` and
            `start` as a whole; `changes_from` names it in the message of an error.

    Raises `RequestError`, one line that names place, key, value and what is allowed.
    """
    if isinstance(source, Scan) and not changes:
        return source
    return _assemble(_open(source), _Layer(changes_from, changes or {}))


@dataclass(frozen=True)
class _Layer:
    """One document of wishes, and the name of the place it comes from."""

    where: str
    document: Mapping[str, Any]

    def __post_init__(self) -> None:
        with at(self.where):
            table("the scan", self.document, FILE_KEYS)

    def table(self, key: str) -> Mapping[str, Any]:
        """Return the table `key`, its own keys checked; empty where there is none."""
        with at(self.place(key)):
            return table(key, self.document.get(key, {}), _KEYS[key])

    def place(self, key: str) -> str:
        """Return the place of the table `key`, for messages."""
        return f"{self.where}: [{key}]"


def _open(source: object) -> _Layer:
    if source is None:
        return _Layer("figure8.toml", parse_toml(resource_text("figure8.toml"), "figure8.toml"))
    if isinstance(source, Scan):
        return _Layer("scan", source.document())
    if isinstance(source, Mapping):
        return _Layer("scan", source)
    if isinstance(source, str | os.PathLike):
        return _Layer(str(source), read_toml(Path(source)))
    raise RequestError(f"scan = {shown(source)} must be a path, a table or a Scan")


def _assemble(below: _Layer, above: _Layer) -> Scan:
    """Return the scan that a document means with another one laid over it."""
    varying = above if above.table("vary") else below
    axes = tuple(_axis(varying, *entry) for entry in varying.table("vary").items())
    system = _system(below, above, varying)
    title = _title(below, above, system, axes)
    sampling, start = _sampling(below) | _sampling(above), _start(below, above)
    want = _want(below, above, system.scene, sampling.get("method", Scan.method))
    with at(varying.place("vary")):
        return Scan(title, system, axes, want, start, **sampling)


def _title(below: _Layer, above: _Layer, system: System, axes: tuple[Axis, ...]) -> str:
    """Return the title given; one made from the scan where none is, or where it is true no more."""
    outdated = above.document.keys() & {"system", "set", "vary"}
    for layer in (above, below):
        if "title" in layer.document and not (layer is below and outdated):
            with at(layer.where):
                return string("title", layer.document["title"])
    varied = [axis.name for axis in axes]
    given = {**below.table("set"), **above.table("set")}.keys() & system.parameters.keys()
    fixed = sorted(given - set(varied))
    settings = "".join(f", {name} = {system.parameters[name]:g}" for name in fixed)
    return f"{system.title or system.name}{settings}: {', '.join(varied)}"


def _axis(layer: _Layer, name: str, entry: object) -> Axis:
    """Return the axis that an entry of `[vary]` means."""
    with at(f"{layer.place('vary')} {name}"):
        return Axis.of(name, entry)


def _system(below: _Layer, above: _Layer, varying: _Layer) -> System:
    """Return the system with the parameters set in both documents, the upper one last."""
    chosen = above if "system" in above.document else below
    with at(chosen.where):
        system = system_from(chosen.document.get("system"))
    varied = varying.table("vary").keys()
    for layer in (below, above):
        given = dict(layer.table("set"))
        with at(layer.place("set")):
            if layer is below and varying is above:  # what is varied above overrides what is set
                given = {name: value for name, value in given.items() if name not in varied}
            else:
                _refuse_set_and_varied(given, varied, varying)
            system = system.with_(**given)
    return system


def _refuse_set_and_varied(
    given: Mapping[str, Any], varied: Collection[str], varying: _Layer
) -> None:
    both = sorted(given.keys() & varied)
    if both:
        raise RequestError(
            f"{both[0]} is varied by {varying.place('vary')}: set it or vary it, not both"
        )
    refuse_contradiction([*given, *varied])


def _start(below: _Layer, above: _Layer) -> Start:
    """Return the start policy; the upper one keeps count and seed of the same policy below."""
    given, known = above.table("start"), below.table("start")
    if given.get("policy", known.get("policy")) != known.get("policy"):
        known = {}
    layer = above if given else below
    with at(layer.place("start")):
        return Start(**{**known, **given})


def _sampling(layer: _Layer) -> dict[str, Any]:
    with at(layer.place("sampling")):
        return {name: _SAMPLING[name](value) for name, value in layer.table("sampling").items()}


def _want(below: _Layer, above: _Layer, scene: Scene, method: str) -> tuple[str, ...]:
    """Return what to record: as asked, or what is usual, without what the scene cannot give.

    So one scan file serves every system; only a request of which nothing remains is refused.
    """
    layer = above if "want" in above.table("record") else below
    with at(layer.place("record")):
        want = checked_want(layer.table("record").get("want", _USUAL_WANT))
        possible = possible_want(want, scene, method)
        if not possible:
            refuse_impossible(want, scene, method)
        return possible
