"""Fills the tables of the reference pages from the program's own: what stands between their marks.

    python docs/site/reference.py            # writes docs/dampers.md, datasets.md, keys.md, ...
    python docs/site/reference.py --check    # says which of them is out of date

A table stands between `<!-- made: NAME -->` and `<!-- end -->`; the text around is written by hand.
"""

from __future__ import annotations

import argparse
import re
import sys
from collections import defaultdict
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from importlib import import_module
from pathlib import Path

import numpy as np

from nlds_vines.__main__ import COMMANDS
from nlds_vines.archives.dataset import Dataset
from nlds_vines.bifurcation.request import Scan, table_of
from nlds_vines.bifurcation.response_curves import Case, CurveRequest, Panel
from nlds_vines.cli.command import Command
from nlds_vines.cli.options import Parser
from nlds_vines.continuation.request import FUNCTION, Begin, Continuation, load_continuation
from nlds_vines.continuation.result import datasets_of as of_branches
from nlds_vines.engine.records import STATUS, WANTS, spectral
from nlds_vines.engine.spectrum import SpectralRecords
from nlds_vines.engine.starts import Start
from nlds_vines.loads.request import Beside, HistoryRequest
from nlds_vines.model.axis import Axis
from nlds_vines.model.loads.loading import ALL, Loading
from nlds_vines.model.loads.record import RecordFile
from nlds_vines.model.parameters import LAWS, PARAMETERS, Parameter, of_second
from nlds_vines.model.ratios import RATIOS, ratios_in
from nlds_vines.model.scenes import BASES, SCENES, Scene
from nlds_vines.model.setting import settings_of
from nlds_vines.model.signals import Signal
from nlds_vines.portrait.request import ColumnEntry, PortraitRequest, Times
from nlds_vines.tuning.request import Search, Surface, Tuning, load_tuning
from nlds_vines.tuning.result import contents

DOCS = Path(__file__).resolve().parents[1]
MARKED = re.compile(r"(<!-- made: (\w+) -->\n).*?(<!-- end -->)", re.DOTALL)

Row = Sequence[str]


def table(heads: Row, rows: Iterable[Row]) -> str:
    """Return a table in Markdown."""
    lines = [heads, ["---"] * len(heads), *rows]
    return "".join(f"| {' | '.join(_cell(text) for text in line)} |\n" for line in lines)


def _cell(text: str) -> str:
    return text.replace("|", "\\|").replace("\n", " ")


def _code(names: Iterable[str]) -> str:
    return ", ".join(f"`{name}`" for name in names)


# ---- dampers and parameters ----------------------------------------------------------------------


def kinds() -> str:
    """Return the table of kinds with the parameters that are their own."""
    rows = (
        (
            f"`{kind}`",
            scene.meaning,
            ", ".join(scene.parameter_names),
            ", ".join(_in_place_of_force(scene)),
        )
        for kind, scene in SCENES.items()
    )
    return table(("kind", "what it is", "parameters", "in place of P"), rows)


def _in_place_of_force(scene: Scene) -> list[str]:
    """Return the parameters that a kind may be given beside its own and those of its contacts."""
    of_contacts = {
        name for law in LAWS.values() for name in (*law.allowed, *of_second(law.allowed))
    }
    return [name for name in scene.allowed if name not in {*scene.parameter_names, *of_contacts}]


def laws() -> str:
    """Return the table of contact laws with their constants."""
    rows = (
        (
            f"`{law.name}`",
            law.meaning,
            (f"{law.instead}, or " if law.instead else "") + ", ".join(law.constants),
            ", ".join(law.optional),
        )
        for law in LAWS.values()
    )
    return table(("law", "contact", "constants", "may be left out (0)"), rows)


def parameters() -> str:
    """Return the table of all parameters."""
    rows = (
        (entry.symbol, f"`{name}`", entry.unit, entry.meaning, _allowed(entry), _where(name))
        for name, entry in PARAMETERS.items()
    )
    return table(("symbol", "name", "unit", "meaning", "allowed", "of"), rows)


def ratios() -> str:
    """Return the table of what may be given in place of parameters."""
    rows = (
        (
            ratio.what.symbol,
            f"`{ratio.name}`",
            ratio.what.unit,
            ratio.what.meaning,
            f"`{ratio.gives}`",
            _code(
                kind for kind, scene in SCENES.items() if ratios_in(scene).get(ratio.name) is ratio
            ),
        )
        for ratio in RATIOS
    )
    return table(("symbol", "name", "unit", "meaning", "in place of", "of"), rows)


def _allowed(entry: Parameter) -> str:
    return entry.allowed.removesuffix(" and finite").replace("finite", "any")


def _where(name: str) -> str:
    """Return the kinds, or the contact laws, that have a parameter."""
    of_kinds = [
        kind
        for kind, scene in SCENES.items()
        if name in (*scene.parameter_names, *_in_place_of_force(scene))
    ]
    if len(of_kinds) == len(SCENES):
        return "all kinds"
    if of_kinds:
        return _code(of_kinds)
    stem = name.removesuffix("_2")
    text = f"law {_code(law.name for law in LAWS.values() if stem in law.allowed)}"
    if stem != name:
        text += f" of the second wall: {_code(k for k, scene in SCENES.items() if scene.second)}"
    return text


# ---- datasets ------------------------------------------------------------------------------------


def of_scans() -> str:
    """Return the table of the datasets of scans, of all kinds, with the records that ask for them.

    The dimensions of the varied parameters are called `axes`.
    """
    entries: dict[str, Dataset] = {}
    asked, kinds_of, shaken_only = defaultdict(set), defaultdict(set), defaultdict(lambda: True)
    for scene in sorted(_variants(), key=lambda scene: -len(_table_of(scene, WANTS))):
        for want in (*((word,) for word in WANTS), WANTS):
            for name, entry in _table_of(scene, want).items():
                if name not in entries or (shaken_only[name] and not scene.shaken):
                    entries[name] = entry  # words of the ground only where nothing else has them
                asked[name] |= set(want) if len(want) == 1 else set()
                kinds_of[name].add(scene.kind)
                shaken_only[name] &= bool(scene.shaken)
    rows = (
        _row(
            entry,
            _records(asked[name]),
            _among(kinds_of[name]) + (", where the ground moves" if shaken_only[name] else ""),
        )
        for name, entry in sorted(entries.items(), key=lambda item: _place_of(asked[item[0]]))
    )
    return table(("dataset", "dimensions", "unit", "meaning", "record", "of"), rows)


def _variants() -> Iterator[Scene]:
    """Yield the scenes of all kinds, under every law, driven by a force and by the ground."""
    for scene in SCENES.values():
        for law in LAWS:
            yield scene.under(law)
            yield scene.under(law, names=BASES)


def _table_of(scene: Scene, want: Sequence[str]) -> Mapping[str, Dataset]:
    """Return the datasets of a scan of a scene from random starts."""
    axes = (Axis.spaced("omega", 5.0, 6.0, 2),)
    spectra = spectral(want)
    signals = {"x": Signal("m", "displacement", "x", np.copy)}
    more = SpectralRecords(spectra, signals, 2, 64, 8.0, "hann") if spectra else None
    return table_of(scene, want, axes, Start("random", 2), 2, more).datasets


def _records(words: set[str]) -> str:
    """Return the words of `[record] want` with one of which a dataset is there."""
    if len(words) == len(WANTS):
        return "always"
    return ", ".join(w for w in WANTS if w in words)


def _place_of(words: set[str]) -> int:
    """Return what to sort datasets by: the first record that asks for them, `always` last."""
    if len(words) == len(WANTS):
        return len(WANTS)
    return min((WANTS.index(w) for w in words), default=WANTS.index("spectrum"))


def _among(found: set[str]) -> str:
    """Return the kinds that have something, in words."""
    sets = {
        "all kinds": set(SCENES),
        "kinds with a damper": {kind for kind, scene in SCENES.items() if scene.damper},
        "kinds with a wall": {kind for kind, scene in SCENES.items() if scene.walls},
    }
    return next((text for text, kinds in sets.items() if kinds == found), _code(sorted(found)))


def _row(entry: Dataset, *more: str) -> Row:
    dims = ("axes" if dim == "omega" else dim for dim in entry.dims)
    return (f"`{entry.name}`", ", ".join(dims), entry.units, entry.long_name, *more)


def of_tunings() -> str:
    """Return the table of the datasets of tunings."""
    tuning = load_tuning({"system": "ssul-set6", "surface": {"parameters": ["k2", "C"]}})
    drawn = load_tuning(tuning, {"uncertain": {"k1": "5%"}})
    one = np.zeros(1)
    columns = defaultdict(lambda: one, dict.fromkeys(tuning.names, one))
    judged = dict.fromkeys(("robustness", "search_best", "surface"), one)
    results = [contents(r, columns, np.zeros(1, int), judged) for r in (drawn, tuning)]
    entries = {entry.name: entry for result in results for entry, _ in result}
    rows = (_row(entry) for entry in entries.values())
    return table(("dataset", "dimensions", "unit", "meaning"), rows)


def of_continuations() -> str:
    """Return the table of the datasets of branches, and of the curves in a plane."""
    plane = {"P": {"start": 400.0, "stop": 1200.0}}
    monitors = {"largest_force": 1.0e4, "NAME": FUNCTION}
    request = load_continuation({"plane": plane, "monitors": monitors, "search": {"tori": 40}})
    rows = map(_row, of_branches(request))
    return table(("dataset", "dimensions", "unit", "meaning"), rows)


def statuses() -> str:
    """Return the table of the statuses of orbits."""
    rows = ((f"`{status.name}`", status.remedy.rstrip(".")) for status in STATUS.values())
    return table(("status", "remedy"), rows)


# ---- request files -------------------------------------------------------------------------------


REQUESTS: Mapping[str, tuple[type, ...]] = {
    "scan": (Start, Scan),
    "response curves": (Start, Scan, CurveRequest, Panel, Case),
    "tuning": (Tuning, Search, Surface, HistoryRequest, Loading, *ALL.values(), RecordFile),
    "portrait": (Times, PortraitRequest, ColumnEntry),
    "continuation": (Begin, Continuation),
    "response history": (HistoryRequest, Beside, Loading, *ALL.values(), RecordFile),
}
"""The kinds of request files, and what describes their keys."""


def keys() -> str:
    """Return the table of the keys whose values are checked one by one."""
    files: dict[tuple[str, str, str], dict[str, str]] = defaultdict(dict)
    for kind, owners in REQUESTS.items():
        for said in (said for owner in owners for said in settings_of(owner).values()):
            files[said.table, said.key, said.words][kind] = said.default_in_words
    tables = list(dict.fromkeys(table for table, _, _ in files))
    rows: dict[Row, list[str]] = defaultdict(list)  # one for tables in which a key is the same
    for (place, key, words), kinds in sorted(files.items(), key=lambda i: tables.index(i[0][0])):
        outer = place.partition(".")[0]
        rows[outer, key, ", ".join(kinds), words, _defaults(kinds)].append(f"`[{place}]`")
    return table(
        ("table", "key", "in", "meaning", "default"),
        ((", ".join(places), f"`{key}`", *rest) for (_, key, *rest), places in rows.items()),
    )


def _defaults(kinds: Mapping[str, str]) -> str:
    """Return a default: what all files have, or what each has that differs from the first."""
    first, *_ = kinds.values()
    others = {kind: value for kind, value in kinds.items() if value != first}
    return "; ".join([first, *(f"{kind}: {value}" for kind, value in others.items())])


# ---- commands ------------------------------------------------------------------------------------


def commands() -> str:
    """Return a section for each command: how it is called, its options, its examples."""
    return "\n".join(
        _section(name, import_module(module).main.__self__)
        for name, (module, _) in COMMANDS.items()
    )


def _section(name: str, command: Command) -> str:
    parser = Parser(prog=f"nlds-vines {name}", add_help=False)
    command.declare(parser)
    actions = parser._actions
    places = " ".join(_place(action) for action in _places_of(actions))
    rows = [row for action in actions if (row := _option(action)) is not None]
    usage = " ".join(filter(None, ("nlds-vines", name, places, "[options]" if rows else "")))
    options = table(("option", "meaning"), rows) + "\n" if rows else ""
    return (
        f"## {name}\n\n{command.description}\n\n"
        f"    {usage}\n\n{options}```console\n{command.examples.strip()}\n```\n"
    )


def _places_of(actions: Iterable[argparse.Action]) -> Iterator[argparse.Action]:
    """Yield the arguments of a command that are no options."""
    return (a for a in actions if not a.option_strings and a.help != argparse.SUPPRESS)


def _place(action: argparse.Action) -> str:
    text = str(action.metavar or action.dest)
    return f"[{text}]" if action.nargs in ("?", "*") else text


def _plain(text: str) -> str:
    """Return a help text as argparse prints it, in which a percent sign is written twice."""
    return text.replace("%%", "%")


def _option(action: argparse.Action) -> Row | None:
    """Return the row of an option, or of an argument that has a help; None for another."""
    if action.help == argparse.SUPPRESS:
        return None
    if not action.option_strings:
        return (f"`{action.metavar or action.dest}`", _plain(action.help)) if action.help else None
    value = f" {action.metavar}" if action.metavar else ""
    names = ", ".join(f"`{text}{value}`" for text in action.option_strings)
    return (names, _plain(action.help or ""))


# ---- pages ---------------------------------------------------------------------------------------

MADE: Mapping[str, Callable[[], str]] = {
    "kinds": kinds,
    "laws": laws,
    "parameters": parameters,
    "ratios": ratios,
    "scans": of_scans,
    "tunings": of_tunings,
    "continuations": of_continuations,
    "statuses": statuses,
    "keys": keys,
    "commands": commands,
}


def filled(text: str) -> str:
    """Return a page with what stands between its marks made anew."""
    return MARKED.sub(lambda found: f"{found[1]}{MADE[found[2]]()}{found[3]}", text)


def pages() -> Iterator[Path]:
    """Yield the pages that have such marks."""
    for path in sorted(DOCS.glob("*.md")):
        if MARKED.search(path.read_text(encoding="utf-8")):
            yield path


def main(arguments: Sequence[str]) -> int:
    """Write the pages, or with --check say which of them would change; return the exit status."""
    old = []
    for path in pages():
        text = path.read_text(encoding="utf-8")
        new = filled(text)
        if new != text:
            old.append(path.name)
            if "--check" not in arguments:
                path.write_text(new, encoding="utf-8")
    print(f"out of date: {', '.join(old)}" if old else "all tables are as the program has them")
    return int(bool(old) and "--check" in arguments)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
