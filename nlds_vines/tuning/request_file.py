"""A tuning file (TOML), or what stands for one, read and checked."""

from __future__ import annotations

import os
from collections.abc import Collection
from math import prod
from typing import Any

from nlds_vines.errors import MOST_CHARACTERS, RequestError, at, choice
from nlds_vines.loads.request import HistoryRequest, is_of_load
from nlds_vines.loads.request_file import flattened
from nlds_vines.model.axis import Axis, announced
from nlds_vines.model.loads.loading import Loading
from nlds_vines.model.parameters import DESCRIBED
from nlds_vines.model.ratios import axes_of_parameters, meant_by, refuse_twice
from nlds_vines.model.request_layers import Document, Form, Layer, Layers
from nlds_vines.model.scenes import Scene
from nlds_vines.model.setting import checks, settings_of
from nlds_vines.model.system import System
from nlds_vines.model.words import range_in_words, setting_in_words, symbol_of
from nlds_vines.tuning.draws import Uncertain
from nlds_vines.tuning.free_parameter import Free, tunable, usual
from nlds_vines.tuning.request import (
    MOST_LANES,
    SAMPLED,
    SAMPLED_FREE,
    UNDER_LOAD,
    Search,
    Surface,
    Tuning,
)

FORM = Form(
    kind="tuning",
    tables={
        "set": None, "free": None, "over": None, "uncertain": None,
        **checks(Tuning, Search, Surface, HistoryRequest, Loading),
    },
)  # fmt: skip
"""What may stand in a tuning file."""

STEADY = tuple(said.key for said in settings_of(Tuning, "sampling").values())
UNDER = tuple(said.key for said in settings_of(HistoryRequest, "sampling").values())
"""What stands in [sampling] of a tuning for the steady state, and under a load."""

DEFAULT_SYSTEM = "ssul-set6"
"""The system whose structure, force and contact are taken unless another one is named."""


def load_tuning(
    source: str | os.PathLike[str] | Document | System | Tuning | None = None,
    changes: Document | None = None,
    changes_from: str = "changes",
) -> Tuning:
    """Return the tuning that a tuning file means, checked throughout.

    Arguments:
        source: path of a TOML file (its name ends in `.toml`), a name of the catalog, the
            document as nested tables, a `System`, a `Tuning`, or None for SSul.
        changes: a document of the same form that overrides it entry by entry; what it sets is no
            longer free.  `changes_from` names it in the message of an error.

    Raises `RequestError`, one line that names place, key, value and what is allowed.
    """
    if isinstance(source, Tuning) and not changes:
        return source
    given = DEFAULT_SYSTEM if source is None else source
    layers = Layers.of(FORM, given, changes, changes_from)
    system = layers.system_as_set(DEFAULT_SYSTEM)
    for layer in layers:
        _refuse_contradiction(layer, system.scene)
    history, sampling = _history(layers, system)
    free, uncertain = _free(layers, system), _uncertain(layers)
    changing = [one.name for one in free] + [one.name for one in uncertain]
    over = _over(layers, system, history, changing)
    title = layers.title(outdated_by=("system", "set", "free", "over", "load", "start"))
    usual_objective = {} if history is None else {"objective": UNDER_LOAD}
    search, surface = Search(**usual_objective | layers.values("search")), _surface(layers)
    with at(layers.holder("over").where):
        tuning = Tuning(
            title=_made_up_title(system, free, over, history) if title is None else title,
            system=system,
            free=free,
            over=over,
            history=history,
            uncertain=uncertain,
            surface=surface,
            search=search,
            **sampling,
        )
    return layers.told(tuning)


def _history(layers: Layers, system: System) -> tuple[HistoryRequest | None, dict[str, Any]]:
    """Return what becomes of designs under a load, None without one; and [sampling] without it.

    What stands in [sampling] of a file for the other sort of tuning is left aside, as a file may be
    for several commands.
    """
    acts, start = layers.values("load"), layers.values("start")
    known = UNDER if acts or start else STEADY
    for name in layers.above.table("sampling"):
        if name not in known:
            why = "without [load] or [start]" if known is STEADY else "under a load"
            with at(layers.above.place("sampling")):
                raise RequestError(f"{name} is not used {why}; allowed: {', '.join(known)}")
    sampling = {k: v for k, v in layers.values("sampling").items() if k in known}
    if known is STEADY:
        periods = SAMPLED if system.scene.walls else SAMPLED_FREE
        return None, {"periods": periods, **sampling}
    with at(layers.place("load" if acts else "start")):
        return HistoryRequest(
            "under a load", (system,), Loading(**acts), (), **start, **sampling
        ), {}


def _uncertain(layers: Layers) -> tuple[Uncertain, ...]:
    """Return what is uncertain; `noise.rms` may stand there as a table of a table, too."""
    with at(layers.place("uncertain")):
        entries = flattened(layers.table("uncertain"))
        return tuple(Uncertain.of(name, entry) for name, entry in entries.items())


def _refuse_contradiction(layer: Layer, scene: Scene) -> None:
    """Raise `RequestError` where a parameter stands in two of the tables set, free and over.

    A ratio stands for its parameter.
    """
    for one, other in (("set", "free"), ("free", "over"), ("set", "over")):
        first = {meant_by(scene, [name])[0]: name for name in layer.table(one)}
        for name in layer.table(other):
            (meant,) = meant_by(scene, [name])
            if meant in first:
                raise RequestError(
                    f"{layer.where}: {first[meant]} stands in [{one}] and {name} in [{other}]: "
                    "one of them only"
                )


def _free(layers: Layers, system: System) -> tuple[Free, ...]:
    """Return what is free: what the file says or what is usual, with the changes laid over it.

    A parameter that the upper layer sets, or gives values of its own, is not free any more.
    """
    below, above = layers

    def meant(names: Collection[str]) -> set[str]:
        return {*meant_by(system.scene, names)}

    unset = [name for name in usual(system.scene) if name not in meant(below.table("set"))]
    entries = below.table("free") if "free" in below.document else {name: {} for name in unset}
    taken = meant([*above.table("set"), *above.table("over")])
    taken |= meant(above.table("free")) - {*above.table("free")}
    kept = {name: entry for name, entry in entries.items() if not meant([name]) & taken}
    wanted: dict[str, Any] = {**kept, **above.table("free")}
    with at(layers.place("free")):
        for name in wanted:
            choice("free parameter", name, tunable(system.scene))
        in_order = [name for name in tunable(system.scene) if name in wanted]
        return tuple(Free.of(name, wanted[name]) for name in in_order)


def _over(
    layers: Layers, system: System, history: HistoryRequest | None, changing: Collection[str]
) -> tuple[Axis, ...]:
    """Return the axes that [over] means; what is `changing` beside them is free or uncertain."""
    with at(layers.place("over")):
        entries = flattened(layers.table("over"))
        cases = prod(announced(entries))
        if cases > MOST_LANES:
            raise RequestError(f"every design has {cases} cases; allowed: up to {MOST_LANES}")
        axes = tuple(Axis.of(*item) for item in entries.items())
        refuse_twice(system.scene, [axis.name for axis in axes])
        of_load = tuple(axis for axis in axes if history is not None and is_of_load(axis.name))
        others = tuple(axis for axis in axes if axis not in of_load)
        names = meant_by(system.scene, [*changing, *(axis.name for axis in others)])
        names += system.following(names)
        return (*axes_of_parameters(others, system.scene, system.parameters, names), *of_load)


def _surface(layers: Layers) -> Surface | None:
    """Return the surface that the table means; None where there is no table."""
    entry = layers.table("surface")
    if not entry:
        return None
    with at(layers.place("surface")):
        return Surface(**{"parameters": None, **entry})


def _made_up_title(
    system: System, free: tuple[Free, ...], over: tuple[Axis, ...], history: HistoryRequest | None
) -> str:
    """Return a title made of the scene, the free parameters and what they are tuned for."""
    names = ", ".join(symbol_of(item.name) for item in free)
    ranges = [range_in_words(axis.name, axis.values) for axis in over if axis.name in DESCRIBED]
    if history is not None:
        ranges.insert(0, history.load.words() or "a free decay")
    elif not {"omega", "omega_ratio"} & {axis.name for axis in over}:
        ranges.insert(0, setting_in_words("omega", system.parameters["omega"]))
    what = system.scene.meaning.split(":")[0]
    return f"{what[:1].upper()}{what[1:]}: {names} tuned for {', '.join(ranges)}"[:MOST_CHARACTERS]
