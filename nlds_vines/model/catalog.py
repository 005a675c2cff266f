"""The named systems of `data/dampers.toml`, systems from files, and the packaged files."""

from __future__ import annotations

import os
import re
from collections.abc import Callable, Iterable, Mapping
from dataclasses import replace
from functools import cache
from importlib.resources import files
from pathlib import Path
from typing import Any

from nlds_vines.archives.files import parse_toml, read_toml
from nlds_vines.errors import RequestError, at, choice, shown, table
from nlds_vines.model.parameters import HERTZ, LAWS, PARAMETERS, SECOND, setting_in_words
from nlds_vines.model.ratios import ratios_in
from nlds_vines.model.scenes import SCENES
from nlds_vines.model.system import NOT_GIVEN, General, Preset, System, general_from

# of a scan file, of which `load_system` reads `system` and `set`
MARKS = (  # keys that only some kinds of request have at the top of their files
    "vary", "samples", "record", "spectrum", "free", "over", "surface", "uncertain", "places",
    "along", "plane", "monitors", "portrait", "column", "figure", "panels", "curves", "systems",
    "load",
)  # fmt: skip
FILE_KEYS = ("title", "system", "set", "start", "search", "sampling", *MARKS)
SYSTEM_KEYS = (
    "kind", "name", "title", "parameters", "sources", "assumptions", "law", "law_2", "contact",
    "contact_2",
)  # fmt: skip
_CLONE = Path(__file__).resolve().parents[2]
_FOLDER_IN_CLONE = {"dampers.toml": "data", "states.json": "data/reference"}  # others: `scans`


@cache
def _document() -> Mapping[str, Any]:
    return parse_toml(resource_text("dampers.toml"), "dampers.toml")


def system_names() -> tuple[str, ...]:
    """Return the names of all systems that come with the program.

    Returns
    -------
    tuple of str
        Names that `load_system` takes, first those of the paper.

    Examples
    --------
    >>> import nlds_vines as nv
    >>> nv.system_names()[:3]
    ('none', 'tmd', 'ssul-set1')
    """
    return (*catalog(), *_document()["hosts"])


@cache
def system_named(name: str) -> System:
    """Return the named system; raise `RequestError` for an unknown name."""
    choice("system", name, system_names())
    if name in catalog():
        return catalog()[name]
    described = dict(_document()["hosts"][name])
    common = described.pop("source")
    own = described.pop("sources")
    system = general_from({"kind": General.kind, **described}, name)
    return replace(system, sources={key: own.get(key, common) for key in system.parameters})


@cache
def catalog() -> Mapping[str, Preset]:
    """Return the named systems of the paper's kinds, with sources and assumptions of values."""
    document, systems = _document(), {}
    for name, entry in document["systems"].items():
        # the values of its groups, overridden by its own
        parts = [document["groups"][group] for group in entry["groups"]]
        parts += [entry] * ("values" in entry)
        texts = {
            note: {key: part[note] for part in parts if note in part for key in part["values"]}
            for note in ("source", "assumption")
        }
        systems[name] = Preset(
            kind=entry["kind"],
            parameters={key: value for part in parts for key, value in part["values"].items()},
            name=name,
            title=entry["title"],
            sources=texts["source"],
            assumptions=texts["assumption"],
            law=entry.get("law", HERTZ.name),
        )
    return systems


def load_system(name_or_path: str | os.PathLike[str], /, **overrides: Any) -> Any:
    """Return a system of the catalog, or one from a TOML file.

    Parameters
    ----------
    name_or_path : str or path-like
        A catalog name, such as "ssul-set6", or the path of a TOML file with a `[system]` table.  Of
        a scan file `system` and `[set]` are read.
    **overrides
        Parameters in SI units and ratios, as `System.with_` takes them; also `law`, with its
        constants.

    Returns
    -------
    System
        The system.

    Raises
    ------
    RequestError
        For an unknown name, a wrong file, and overrides that `System.with_` refuses.

    Examples
    --------
    >>> import nlds_vines as nv
    >>> system = nv.load_system("ssul-set6", omega=7.45, law="restitution", e=0.7)
    >>> system.parameters["omega"], system.parameters["e"]
    (7.45, 0.7)
    """
    return any_system(name_or_path).with_(**overrides)


def any_system(source: System | str | os.PathLike[str], *, needs_force: bool = True) -> System:
    """Return a system as it is, otherwise that of a catalog name or a TOML file."""
    if isinstance(source, System) or (isinstance(source, str) and not looks_like_path(source)):
        return any_system_from(source)
    if not isinstance(source, str | os.PathLike):
        raise RequestError(
            f"system = {shown(source)} must be a System, a name or the path of a TOML file; "
            f"names: {', '.join(system_names())}"
        )
    path = str(Path(source))
    document = read_request(source)
    with at(path):
        table("the file", document, FILE_KEYS)
        system = any_system_from(document.get("system"), path, needs_force=needs_force)
        with at("[set]"):
            return system.with_(**table("set", document.get("set", {})))


def as_preset(source: System | str | os.PathLike[str]) -> Preset:
    """Return `any_system`; raise `RequestError` for a host."""
    return without_hosts(any_system(source))


def without_hosts(system: System) -> Preset:
    """Return a system of one structure and one damper; raise `RequestError` for a host."""
    if not isinstance(system, Preset):
        raise RequestError(
            f"kind {system.kind!r} is not possible here; allowed: {', '.join(SCENES)}"
        )
    return system


def told_apart(systems: Iterable[System]) -> tuple[str, ...]:
    """Return the words for systems that stand side by side: each has words of its own.

    Of two that have the same, each gets the name of its file; if that is the same, too, the second
    is told by the numbers in which it differs from the first, or else is numbered.
    """
    systems = tuple(systems)
    plain = [system.in_words() for system in systems]
    told: list[str] = []
    for place, (system, words) in enumerate(zip(systems, plain, strict=True)):
        alike = [systems[i] for i, other in enumerate(plain) if other == words]
        if any(other.name != system.name for other in alike):
            words = f"{words} ({Path(system.name).name})"
        earlier = [other for other in systems[:place] if other in alike]
        first = next((other for other in earlier if other.name == system.name), None)
        if first is not None and system.has_parts_of(first):
            for name, value in system.changes_from(first).items():
                is_place = isinstance(value, str | tuple)
                change = f"{name} = {value}" if is_place else setting_in_words(name, value)
                words = f"{words}, {change}"
        number = told.count(words) + 1
        told.append(words if number == 1 else f"{words} [{number}]")
    return tuple(told)


def looks_like_path(text: str) -> bool:
    return text.endswith(".toml") or "/" in text or os.sep in text


def any_system_from(value: object, name: str = "", *, needs_force: bool = True) -> System:
    """Return the system of the entry `system` of a request file: a name, a system, or a table.

    A table gets the default `name`.  With `needs_force` it must have amplitude and frequency of the
    harmonic force; a load in time needs none, and `System.refuse_without_force` refuses them
    elsewhere.
    """
    if isinstance(value, System):
        return value
    if isinstance(value, str):
        return system_named(value)
    if not isinstance(value, Mapping):
        what = "no system" if value is None else f"system = {shown(value)}"
        raise RequestError(
            f"{what}: give system = NAME, or a [system] table with kind and parameters; "
            f"names: {', '.join(system_names())}"
        )
    with at("[system]"):
        if "kind" not in value:
            raise RequestError(f"kind is missing; allowed: {', '.join(_FORMS)}")
        read = _FORMS[choice("kind", value["kind"], _FORMS)]
        return read(value, name, needs_force=needs_force)


def _preset_from(value: Mapping[str, Any], name: str, *, needs_force: bool) -> Preset:
    """Return the system of a table [system] of one of the paper's kinds."""
    kind = value["kind"]
    contact, law = _contact(value, "contact", "law", HERTZ.name)
    second, law_2 = _contact(value, "contact_2", "law_2", "")
    # a parameter of another kind is refused by `System`, whose message names that parameter
    scene = SCENES[kind].under(law, law_2)
    ratios = ratios_in(scene)
    foreign = {key: v for key, v in value.items() if not (key in PARAMETERS or key in ratios)}
    table("system", foreign, (*SYSTEM_KEYS, *scene.allowed, *ratios))
    parameters: dict[str, Any] = {}
    for place, constants in (
        ("[system]", {key: v for key, v in value.items() if key not in foreign}),
        ("[system.parameters]", table("parameters", value.get("parameters", {}))),
        ("[system.contact]", contact),
        ("[system.contact_2]", {key + SECOND: v for key, v in second.items()}),
    ):
        if twice := sorted(parameters.keys() & constants.keys()):
            raise RequestError(f"{twice[0]} stands in {place}, and before it")
        parameters |= constants
    sources = dict(table("sources", value.get("sources", {})))
    if not needs_force:
        for names, usual in ((scene.drives, 0.0), (("omega", "f", "omega_ratio"), 1.0)):
            if parameters.keys().isdisjoint(names):
                parameters[names[0]], sources[names[0]] = usual, NOT_GIVEN
    title, assumptions = value.get("title", ""), value.get("assumptions", {})
    name = value.get("name", name)
    return Preset(kind, parameters, name, title, sources, assumptions, law, law_2)


_FORMS: Mapping[str, Callable[..., System]] = {
    **dict.fromkeys(SCENES, _preset_from),
    General.kind: general_from,
}
"""What reads the table of a system, by its kind."""


def _contact(
    entry: Mapping[str, Any], place: str, key: str, law: str
) -> tuple[dict[str, Any], str]:
    """Return the constants in the table `place` of a system, and its law, by default `law`."""
    constants = dict(table(place, entry.get(place, {})))  # the law stands there or beside the kind
    if key in entry and "law" in constants:
        raise RequestError(f"{key} stands in [system], and law in [system.{place}]")
    law_name = constants.pop("law", entry.get(key, law))
    if law_name == law == "":
        if constants:
            raise RequestError(f"[system.{place}] has no law; allowed: {', '.join(LAWS)}")
        return {}, ""
    choice(key, law_name, LAWS)
    with at(f"[{place}]"):
        table(place, constants, ("law", *LAWS[law_name].allowed))
    return constants, law_name


# ---- files that come with the program ------------------------------------------------------------


def resource_text(name: str) -> str:
    return resource_path(name).read_text(encoding="utf-8")


def resource_path(name: str) -> Path:
    """Return the path of a packaged file: in `nlds_vines/_data` of a wheel, else in the clone."""
    packed = _packed() / name
    return packed if packed.is_file() else _CLONE / _FOLDER_IN_CLONE.get(name, "scans") / name


def request_path(source: str | os.PathLike[str]) -> Path:
    """Return the path of a request file; a bare name that does not exist is a packaged one's."""
    path = Path(source)
    packaged = resource_path(path.name)
    is_missing = path.name == os.fspath(source) and not os.path.lexists(path)
    return packaged if is_missing and packaged.is_file() else path


# keys of request files whose texts are paths
_PATHS = re.compile(r"load\.record(\.file)?|samples\.file|systems?(\..*)?\.host\.(file|M|K|C)")
_NAMES = re.compile(r"systems?|(panels|curves)\.system")  # likewise, or names of the catalog


def read_request(source: str | os.PathLike[str]) -> dict[str, Any]:
    """Return the document in a request file; its relative paths count from the file's folder."""
    path = request_path(source)
    document: dict[str, Any] = _located(read_toml(path), path.parent)
    return document


def _located(value: Any, folder: Path, key: str = "") -> Any:
    """Return the value of a key of a document, with its paths relative to the working folder."""
    if isinstance(value, Mapping):
        prefix = f"{key}." if key else ""
        return {name: _located(one, folder, f"{prefix}{name}") for name, one in value.items()}
    if isinstance(value, list):
        return [_located(one, folder, key) for one in value]
    if not isinstance(value, str) or not value:
        return value
    is_path = _PATHS.fullmatch(key) or (_NAMES.fullmatch(key) and looks_like_path(value))
    return str(folder / value) if is_path else value


def figure_files() -> list[Path]:
    folder = _packed() if _packed().is_dir() else _CLONE / "scans"
    return sorted([*folder.glob("figure*.toml"), *folder.glob("study-*.toml")])


def _packed() -> Path:
    return Path(str(files("nlds_vines") / "_data"))
