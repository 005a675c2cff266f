"""Writes the schema of request files, by which editors complete keys and underline mistakes.

    python docs/site/schema.py               # writes docs/static/request.schema.json

One schema holds for all request files, as one file may serve several commands.  It follows from the
settings of the requests; what depends on several keys at once, only the program itself refuses.
"""

from __future__ import annotations

import json
from collections.abc import Iterable
from pathlib import Path
from typing import Any

from reference import REQUESTS

from nlds_vines import errors
from nlds_vines.continuation.request import FUNCTION
from nlds_vines.model.axis import FILE
from nlds_vines.model.catalog import SYSTEM_KEYS, system_names
from nlds_vines.model.dampers import DAMPER_KEYS, SPRING_KEYS, WALL_KEYS
from nlds_vines.model.host import KEYS as HOST_KEYS
from nlds_vines.model.loads.loading import NUMBERS as NUMBERS_OF_LOADS
from nlds_vines.model.loads.record import Record, RecordFile
from nlds_vines.model.parameters import INITIAL, LAWS, PARAMETERS, RATIOS
from nlds_vines.model.scenes import SCENES
from nlds_vines.model.setting import (
    Check,
    OneOf,
    Real,
    Text,
    Truth,
    Whole,
    settings_of,
)
from nlds_vines.model.system import FORCE_KEYS, GENERAL_KEYS, General
from nlds_vines.tuning.design_space import NORMAL, UNIFORM

PATH = Path(__file__).resolve().parents[1] / "static" / "request.schema.json"

Schema = dict[str, Any]

SPREADS: list[Schema] = [{"type": "string", "pattern": "%$"}, {"type": "number"}]
NUMBERS: Schema = {"type": "array", "items": {"type": "number"}}
AXIS = {
    "start": {"type": "number"},
    "stop": {"type": "number"},
    "num": {"type": "integer", "minimum": 1},
    "scale": {"enum": ["linear", "log"]},
    "values": NUMBERS,
}


def named(names: Iterable[str], of_each: Schema, loads: bool = False) -> Schema:
    """Return the schema of a table whose keys are of these names, each with a value `of_each`.

    With `loads` there may be numbers of a load, too.  Numbers of a load's kind, of a host's damper
    and forces on it have a point in their names, or stand in a table of their own.
    """
    keys = "|".join([*names, *(NUMBERS_OF_LOADS if loads else ())])
    return {
        "type": "object",
        "patternProperties": {f"^({keys})$": of_each, "[.]": of_each},
        "additionalProperties": {"type": "object", "additionalProperties": of_each},
    }


def table(properties: Schema) -> Schema:
    """Return the schema of a table with these keys, and no others."""
    return {"type": "object", "properties": properties, "additionalProperties": False}


def of(check: Check) -> Schema:
    """Return the schema of the values that a check lets through; {} where it depends."""
    match check:
        case Whole(low, high):
            return {"type": "integer", "minimum": low, "maximum": high}
        case Real(low, high):
            return {"type": "number", "minimum": low, "maximum": high}
        case OneOf(words):
            return {"enum": list(words)}
        case Text():
            return {"type": "string"}
        case Truth():
            return {"type": "boolean"}
    return {"type": "object"} if check is errors.table else {}


def tables() -> dict[str, Schema]:
    """Return the tables of settings; a key that means several things may have any of its forms."""
    found: dict[str, dict[str, list[Schema]]] = {}
    for owner in dict.fromkeys(owner for owners in REQUESTS.values() for owner in owners):
        for said in settings_of(owner).values():
            forms = found.setdefault(said.table, {}).setdefault(said.key, [])
            one = {"description": said.words} | of(said.check)
            forms += [] if one in forms else [one]
    written = {
        name: table(
            {key: forms[0] if len(forms) == 1 else {"anyOf": forms} for key, forms in keys.items()}
        )
        for name, keys in found.items()
    }
    return {
        name.strip("[]"): {"type": "array", "items": one} if name.startswith("[") else one
        for name, one in _nested(written).items()
    }


def _nested(tables: dict[str, Schema]) -> dict[str, Schema]:
    """Return tables with those of dotted names within the others: one, or a list of several."""
    outer = {name: one for name, one in tables.items() if "." not in name}
    for name, one in tables.items():
        place, _, key = name.partition(".")
        if key:
            if key == Record.kind:  # of which a file may hold the samples
                one["properties"] |= {e.key: of(e.check) for e in settings_of(RecordFile).values()}
            forms = [one, {"type": "array", "items": one}, {"type": "string"}]
            outer[place]["properties"][key] |= {"anyOf": forms}
    return outer


def keys(names: Iterable[str], **known: Schema) -> Schema:
    """Return the schema of a table with keys of these names; values without a schema are free."""
    return table({name: known.get(name, {}) for name in names})


def system_of_a_kind() -> Schema:
    """Return the schema of a system of one of the kinds with formulas of their own."""
    names = [*PARAMETERS, *RATIOS]
    texts = {"type": "object", "additionalProperties": {"type": "string"}}
    constants = keys(["law", *(name for law in LAWS.values() for name in law.allowed)])
    return keys(
        dict.fromkeys([*SYSTEM_KEYS, *names]),
        kind={"enum": list(SCENES)},
        parameters=keys(names),
        sources=texts,
        assumptions=texts,
        contact=constants,
        contact_2=constants,
    )


def system_of_a_host() -> Schema:
    """Return the schema of a host with dampers and forces."""
    walls = {"type": "array", "items": keys(WALL_KEYS)}
    spring = keys(SPRING_KEYS, **{key: {"type": "number"} for key in SPRING_KEYS})
    return keys(
        GENERAL_KEYS,
        kind={"enum": [General.kind]},
        host=keys(dict.fromkeys(key for one in HOST_KEYS.values() for key in one)),
        dampers={"type": "array", "items": keys(DAMPER_KEYS, walls=walls, spring=spring)},
        force=keys(FORCE_KEYS),
    )


def schema() -> Schema:
    """Return the schema of a request file."""
    of_host: Schema = {"type": ["number", "string", "array"]}  # also attached_to
    settings = named((), of_host) | {
        "properties": {
            name: {"type": "number", "description": f"{entry.meaning} [{entry.unit}]"}
            for name, entry in PARAMETERS.items()
        }
        | {law: {"enum": list(LAWS)} for law in ("law", "law_2")}
    }
    interval = table({"low": {"type": "number"}, "high": {"type": "number"}})
    spread = table({"spread": {"anyOf": SPREADS}, "law": {"enum": [NORMAL, UNIFORM]}})
    ends = table({"start": {"type": "number"}, "stop": {"type": "number"}})
    names = {"anyOf": [{"enum": list(system_names())}, {"type": "string"}]}
    # conditions, and no alternatives, so that editors underline the wrong key and not the table
    is_host = {"properties": {"kind": {"const": General.kind}}, "required": ["kind"]}
    own = {"if": is_host, "then": system_of_a_host(), "else": system_of_a_kind()}
    system = {"if": {"type": "string"}, "then": names, "else": own}
    return {
        "$schema": "http://json-schema.org/draft-07/schema#",
        "title": "nlds_vines: a request file",
    } | table(
        {
            "title": {"type": "string", "maxLength": 1000},
            "system": system,
            "systems": {"type": "array", "items": system},
            "set": settings,
            "vary": named((*PARAMETERS, *INITIAL), table(AXIS), loads=True),
            "samples": named((*PARAMETERS, *INITIAL, *RATIOS, FILE), {"type": ["array", "string"]}),
            "over": named(PARAMETERS, table(AXIS), loads=True),
            "uncertain": named(PARAMETERS, {"anyOf": [*SPREADS, spread]}, loads=True),
            "free": named(PARAMETERS, interval),
            "places": {"type": "object", "additionalProperties": {"type": "array"}},
            "along": named(PARAMETERS, ends),
            "plane": named(PARAMETERS, ends),
            "monitors": {
                "type": "object",
                "additionalProperties": {
                    "anyOf": [{"type": "number"}, NUMBERS, {"enum": [FUNCTION]}]
                },
            },
            **tables(),
        }
    )


def text() -> str:
    """Return the file."""
    return json.dumps(schema(), indent=1, ensure_ascii=False) + "\n"


if __name__ == "__main__":
    PATH.write_text(text(), encoding="utf-8")
