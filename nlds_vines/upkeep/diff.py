"""The differences of two archives: of their parameters, their results and their circumstances.

As a command: `nlds-vines diff A.h5 B.h5`.
"""

from __future__ import annotations

import argparse
import hashlib
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from nlds_vines.archives.toml import parse_toml
from nlds_vines.cli.command_main import DIFFERENT, DONE, Command, say
from nlds_vines.cli.parser import Parser
from nlds_vines.cli.paths import existing
from nlds_vines.errors import shown

if TYPE_CHECKING:
    from nlds_vines.archives.archive import ArchiveView

_EXAMPLES = """\
examples:
  nlds-vines diff figure8.h5 figure8-rerun.h5
      parameters and results, to the last bit; versions are named, but do not count
exit status: 0 no difference; 1 parameters or results differ; 2 the request is wrong
"""
_PROSE = ("title", "system.name", "system.title", "system.sources", "system.assumptions")
_CIRCUMSTANCES = ("title", "commit", "threads", "machine", "source", "source_hash")
_ADDED = ("start_state", "period", "optimum_finer")  # older archives may lack these
_NONE = "none"


@dataclass
class Differences:
    """The differences of two archives, one line each."""

    parameters: list[str] = field(default_factory=list)
    results: list[str] = field(default_factory=list)
    circumstances: list[str] = field(default_factory=list)

    @property
    def different(self) -> bool:
        """Whether parameters or results differ; circumstances do not count."""
        return bool(self.parameters or self.results)

    def lines(self) -> list[str]:
        """Return all lines, each with its kind in front."""
        same = [] if self.different else ["parameters and results are the same"]
        parameters = [f"parameter: {line}" for line in self.parameters]
        results = [f"result: {line}" for line in self.results]
        circumstances = [f"made by: {line}" for line in self.circumstances]
        return [*same, *parameters, *results, *circumstances]


def compare(one: Path, other: Path) -> Differences:
    """Return the differences of two archives.

    Raises `RequestError` if one of them cannot be read.
    """
    from nlds_vines.archives import archive

    with archive.read(one) as a, archive.read(other) as b:
        return Differences(
            list(_changes(_parameters(a), _parameters(b))),
            list(_of_results(a, b)),
            list(_changes(_circumstances(a), _circumstances(b))),
        )


def _changes(one: Mapping[str, str], other: Mapping[str, str]) -> Iterator[str]:
    """Yield `name: old -> new` for everything in which two tables differ."""
    for name in dict.fromkeys([*one, *other]):
        old, new = one.get(name, _NONE), other.get(name, _NONE)
        if old != new:
            yield f"{name}: {old} -> {new}"


def _parameters(view: ArchiveView) -> dict[str, str]:
    """Return the parameters by the dotted names of the request file, without titles and sources."""
    asked = _leaves(parse_toml(view.text("scan"), f"{view.path}: its scan"), "")
    return {name: value for name, value in asked if not name.startswith(_PROSE)}


def _leaves(value: Any, name: str) -> Iterator[tuple[str, str]]:
    if isinstance(value, Mapping):
        for key, inner in value.items():
            yield from _leaves(inner, f"{name}.{key}" if name else key)
    elif isinstance(value, list) and len(value) > 4 and all(isinstance(x, float) for x in value):
        # the digest differs where first, last and number are the same
        digest = hashlib.sha256(np.array(value).tobytes()).hexdigest()[:12]
        yield name, f"{len(value)} values from {value[0]!r} to {value[-1]!r}, {digest}"
    else:
        yield name, shown(value)


def _circumstances(view: ArchiveView) -> dict[str, str]:
    """Return what may explain a difference of results: versions, commit, machine, threads."""
    attrs = view.attrs
    versions = sorted(name for name in attrs if name.endswith("_version"))
    return {name: str(attrs.get(name, _NONE)) for name in (*_CIRCUMSTANCES, *versions)}


def _of_results(a: ArchiveView, b: ArchiveView) -> Iterator[str]:
    """Yield one line for every dataset that differs."""
    for name in dict.fromkeys([*a.names, *b.names]):
        if name.removesuffix("_down") in _ADDED and (name in a.names) != (name in b.names):
            continue
        if name not in a.names or name not in b.names:
            yield f"{name} is only in {(a if name in a.names else b).path}"
        elif (a.dims(name), a.shape(name)) != (b.dims(name), b.shape(name)):
            yield f"{name} has {_sides(a, name)} in one and {_sides(b, name)} in the other"
        elif a.is_text(name) != b.is_text(name):
            yield f"{name} holds strings in {(a if a.is_text(name) else b).path} alone"
        else:
            yield from _of_values(a, b, name)


def _sides(view: ArchiveView, name: str) -> str:
    pairs = zip(view.dims(name), view.shape(name), strict=True)
    return " x ".join(f"{length} {dim}" for dim, length in pairs)


def _of_values(a: ArchiveView, b: ArchiveView, name: str) -> Iterator[str]:
    """Yield one line for a dataset that differs: how many values, by how much, which first."""
    count, largest, first, row = 0, 0.0, None, 0
    for old, new in zip(a.slabs(name), b.slabs(name), strict=True):
        where = np.argwhere(_differ(old, new))
        if len(where):
            place = tuple(where.T)
            largest = max(largest, _distance(old[place], new[place]))
            first = first if first is not None else (row + where[0][0], *where[0][1:])
        count, row = count + len(where), row + len(old)
    if first is not None:
        total = int(np.prod(a.shape(name)))
        by = f" by up to {largest:.3g}" if largest else ""
        yield f"{name}: {count} of {total} values differ{by}, first at {_place(a, name, first)}"


def _differ(old: np.ndarray, new: np.ndarray) -> np.ndarray:
    """Return where values differ; floats are compared by their bits, so that NaN equals NaN."""
    if old.dtype == new.dtype == np.float64:
        return np.ascontiguousarray(old).view(np.int64) != np.ascontiguousarray(new).view(np.int64)
    return np.asarray(old != new)


def _distance(old: np.ndarray, new: np.ndarray) -> float:
    """Return the largest distance between numbers; 0 where there are none."""
    if old.dtype == object:
        return 0.0
    with np.errstate(invalid="ignore"):
        distances = np.abs(old.astype(float) - new.astype(float))
    return float(np.max(distances[np.isfinite(distances)], initial=0.0))


def _place(view: ArchiveView, name: str, index: tuple[int, ...]) -> str:
    """Return an index in words: `omega = 7.375, start = rest`."""
    pairs = zip(view.dims(name), index, strict=True)
    return ", ".join(f"{dim} = {view[dim][i]}" for dim, i in pairs)


def _carry_out(options: argparse.Namespace) -> int:
    """Compare two archives; return the exit status."""
    found = compare(existing(options.one), existing(options.other))
    say(*found.lines())
    return DIFFERENT if found.different else DONE


def _declare(parser: Parser) -> None:
    parser.add_argument("one", metavar="A.h5", help="an archive")
    parser.add_argument("other", metavar="B.h5", help="another archive")


COMMAND = Command(
    name="diff",
    description="Say what differs between two archives, in parameters and in results.",
    examples=_EXAMPLES,
    declare=_declare,
    carry_out=_carry_out,
)
main = COMMAND.main
