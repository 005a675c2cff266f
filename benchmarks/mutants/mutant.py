"""One mutant: a small change in a source that some tests must notice."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path


class StaleError(ValueError):
    """A mutant no longer fits the sources: its text is not there, or there more than once."""


@dataclass(frozen=True)
class Mutant:
    """A source with `old` replaced by `new` is wrong, and each of `tests` must fail on it.

    `old` stands exactly once in `file` (from the root of the checkout). `tests` are pytest's names
    of tests; one that has parameters fails if one of its cases does.
    """

    name: str  # the file's subject, and what is wrong then
    file: str
    old: str
    new: str
    tests: tuple[str, ...]

    def applied_to(self, text: str) -> str:
        """Return a source with the change; raises `StaleError` unless `old` stands once in it."""
        times = text.count(self.old)
        if times != 1 or self.old == self.new:
            where = f"its text stands {times} times in {self.file}"
            raise StaleError(
                f"mutant {self.name!r}: {where if times != 1 else 'it changes nothing'}"
            )
        return text.replace(self.old, self.new)


def of(file: str, *changes: tuple[str, ...]) -> tuple[Mutant, ...]:
    """Return the mutants of a file from tuples (name, old, new, test, ...)."""
    return tuple(Mutant(name, file, old, new, tuple(tests)) for name, old, new, *tests in changes)


def check(mutants: Iterable[Mutant], checkout: Path) -> None:
    """Raise `StaleError` unless every mutant fits the sources of a checkout."""
    for mutant in mutants:
        try:
            text = (checkout / mutant.file).read_text(encoding="utf-8")
        except FileNotFoundError:
            raise StaleError(f"mutant {mutant.name!r}: no file {mutant.file}") from None
        mutant.applied_to(text)
