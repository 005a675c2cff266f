"""A scan file (TOML), read and checked, with the changes of the command line laid over it."""

from __future__ import annotations

import os
from collections.abc import Collection, Mapping
from typing import Any

from nlds_vines.archives.toml import parse_toml
from nlds_vines.bifurcation.request import Scan, refuse_too_many
from nlds_vines.errors import RequestError, at
from nlds_vines.model.axis import MOST_VALUES, Axis, announced
from nlds_vines.model.catalog import as_system, looks_like_path, resource_text
from nlds_vines.model.ratios import axes_of_parameters, meant_by
from nlds_vines.model.request_layers import Form, Layer, Layers
from nlds_vines.model.scenes import Scene
from nlds_vines.model.setting import checks
from nlds_vines.model.system import System, refuse_contradiction
from nlds_vines.model.words import setting_in_words, symbol_of, system_in_words
from nlds_vines.orbits.records import USUAL, possible_want, refuse_impossible
from nlds_vines.orbits.solver_settings import FINENESS, chosen_settings, laid_over
from nlds_vines.orbits.starts import STATE, Start

FORM = Form(
    kind="scan",
    tables={"set": None, "vary": None, **checks(Start, Scan)},
    names=False,
    sources="a path, a name, a table, a System or a Scan",
)
"""What may stand in a scan file."""

DEFAULT_FILE = "figure8.toml"
"""The packaged scan that is taken unless another one is given."""


def load_scan(
    source: str | os.PathLike[str] | Mapping[str, Any] | Scan | System | None = None,
    changes: Mapping[str, Any] | None = None,
    changes_from: str = "changes",
) -> Scan:
    """Return the scan that a scan file means, checked throughout.

    Arguments:
        source: path of a TOML file, the document in it as nested tables, a `Scan`, or None for
            the embedded default (Figure 8); a `System`, or the name of one, for the default of it.
        changes: a document of the same form that overrides it entry by entry, though `vary` and
            `start` as a whole; `changes_from` names it in the message of an error.

    Raises `RequestError`, one line that names place, key, value and what is allowed.
    """
    if isinstance(source, Scan) and not changes:
        return source
    if isinstance(source, System) or (isinstance(source, str) and not looks_like_path(source)):
        return load_scan(None, {"system": as_system(source), **(changes or {})}, changes_from)
    if source is not None:
        return _scan(Layers.of(FORM, source, changes, changes_from))
    usual = parse_toml(resource_text(DEFAULT_FILE), DEFAULT_FILE)
    if (changes or {}).get("system"):
        del usual["set"]  # what the default scan sets is meant for its own system
    below = Layer(FORM, DEFAULT_FILE, usual)
    return _scan(Layers.of(FORM, below, changes, changes_from))


def _scan(layers: Layers) -> Scan:
    """Return the scan that the layers mean together."""
    varying = layers.holder("vary")
    start = _start(layers)
    axes = _axes(varying, start.orbits)
    system = _system(layers, varying)
    sampling = _sampling(layers) | layers.values("spectrum")
    want = _want(layers, system.scene)
    with at(varying.place("vary")):
        changing = meant_by(system.scene, [axis.name for axis in axes])
        changing += system.following(changing)
        axes = axes_of_parameters(axes, system.scene, system.parameters, changing)
    title = layers.title(outdated_by=("system", "set", "vary"))
    if title is None:
        title = _made_up_title(layers, system, axes)
    with at(varying.place("vary")):
        scan = Scan(title, system, axes, want, start, **sampling)
    return layers.told(scan)


def _made_up_title(layers: Layers, system: System, axes: tuple[Axis, ...]) -> str:
    """Return a title made of the system, the parameters that are set, and those that vary."""
    varied = [axis.name for axis in axes]
    system = system.with_axes(varied)  # without a force, where the ground's motion varies
    given = {*layers.table("set"), *meant_by(system.scene, layers.table("set"))}
    fixed = sorted((given & system.statements.keys()) - set(varied))
    settings = "".join(f", {setting_in_words(name, system.statements[name])}" for name in fixed)
    symbols = ", ".join(symbol_of(name) for name in varied)
    return f"{system_in_words(system)}{settings}: {symbols}"


def _axes(layer: Layer, starts: int) -> tuple[Axis, ...]:
    """Return the axes that `[vary]` means, once it is sure that they are not too long together."""
    entries = layer.table("vary")
    with at(layer.place("vary")):
        shape = announced(entries)
        if len(shape) == 2 and max(shape) <= MOST_VALUES:
            refuse_too_many(shape, starts)
    axes = []
    for name, entry in entries.items():
        with at(f"{layer.place('vary')} {name}"):
            axes.append(Axis.of(name, entry))
    return tuple(axes)


def _system(layers: Layers, varying: Layer) -> System:
    """Return the system with the parameters set in both layers, the upper one last."""
    system = layers.system()
    varied = set(meant_by(system.scene, varying.table("vary")))
    for layer in layers:
        settings = dict(layer.table("set"))
        with at(layer.place("set")):
            if layer is layers.below and varying is layers.above:
                # what the command line varies need not be removed from [set] of the file
                kept = zip(meant_by(system.scene, settings), settings.items(), strict=True)
                settings = dict(item for name, item in kept if name not in varied)
            else:
                _refuse_set_and_varied(meant_by(system.scene, settings), varied, varying)
            system = system.with_(**settings)
    return system


def _refuse_set_and_varied(
    settings: Collection[str], varied: Collection[str], varying: Layer
) -> None:
    both = sorted(set(settings) & set(varied))
    if both:
        raise RequestError(
            f"{both[0]} is varied by {varying.place('vary')}: set it or vary it, not both"
        )
    refuse_contradiction([*settings, *varied])


def _start(layers: Layers) -> Start:
    """Return the start policy; the upper one keeps count and seed of the same policy below."""
    asked, known = (_with_policy(layer.table("start")) for layer in (layers.above, layers.below))
    if asked.get("policy", known.get("policy")) != known.get("policy"):
        known = {}
    with at(layers.place("start")):
        return Start(**{**known, **asked})


def _with_policy(start: Mapping[str, Any]) -> dict[str, Any]:
    """Return the entries of [start], with the policy that a state alone means."""
    return ({"policy": STATE} if "state" in start else {}) | dict(start)


def _sampling(layers: Layers) -> dict[str, Any]:
    """Return the entries of [sampling], once it is sure that its method has what is asked of it."""
    below, above = (layer.values("sampling") for layer in layers)
    found = laid_over(below, above)
    asking = layers.above if above.keys() & {"method", *FINENESS} else layers.below
    with at(asking.place("sampling")):
        fineness = {name: found.get(name) for name in FINENESS}
        chosen_settings(found.get("method", Scan.method), fineness)
    return found


def _want(layers: Layers, scene: Scene) -> tuple[str, ...]:
    """Return what to record: as asked, or what is usual, without what the scene cannot give.

    So one scan file serves every system; only a request of which nothing remains is refused.
    """
    want = layers.values("record").get("want", USUAL)
    with at(layers.place("record")):
        possible = possible_want(want, scene)
        if not possible:
            refuse_impossible(want, scene)
        return possible
