"""What the command `accuracy` can measure: error against run time, and against stiffness."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, Protocol

from nlds_vines.errors import RequestError, from_text, whole

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from nlds_vines.accuracy.rivals import Rival
    from nlds_vines.accuracy.survey import Survey
    from nlds_vines.archives.archive import ArchiveView
    from nlds_vines.model.system import System


class Mode(Protocol):
    """What is measured, drawn and printed; kernels and matplotlib are loaded by its methods."""

    @property
    def default(self) -> str:
        """Name of the archive where none is given."""

    def survey(self) -> Survey:
        """Return what is to be measured."""

    def draw(self, view: ArchiveView) -> Figure:
        """Return the picture of an archive."""

    def lines(self, view: ArchiveView) -> Iterator[str]:
        """Yield what an archive says."""

    def page(self, view: ArchiveView, picture: str, command: str) -> str:
        """Return what an archive says as a page of its own."""


@dataclass(frozen=True)
class Compared:
    """Error against run time, on one system or on the suite; `want` asks for advice.

    `rivals` are measured beside those of the package, where they are installed; None: no rival.
    """

    system: System
    periods: int | None
    want: float | None
    suite: bool
    rivals: tuple[Rival, ...] | None
    default: str = "accuracy.h5"

    def survey(self) -> Survey:
        """Return the measurements of every method on every case."""
        from nlds_vines.accuracy.cases import of_system, suite
        from nlds_vines.accuracy.comparison import comparison

        cases = list(suite()) if self.suite else [of_system(self.system)]
        if self.periods is not None:
            cases = [replace(case, periods=self.periods) for case in cases]
        return comparison(cases, "Error against run time", _there(self.rivals))

    def draw(self, view: ArchiveView) -> Figure:
        """Return a panel for each case."""
        from nlds_vines.accuracy.comparison_table import read_comparison
        from nlds_vines.accuracy.picture import draw_comparison

        return draw_comparison(read_comparison(view))

    def lines(self, view: ArchiveView) -> Iterator[str]:
        """Yield tables, ratios and advice, case by case."""
        from nlds_vines.accuracy import comparison_page as tables
        from nlds_vines.accuracy.comparison_table import read_comparison

        for case in read_comparison(view):
            yield from (*tables.head(case), "")
            if not self.suite:
                yield from (*tables.measurements(case), "")
            yield from (*tables.summary(case), "", tables.verdict(case))
            yield from (*tables.ratios(case), *tables.advice(case, self.want), "")

    def page(self, view: ArchiveView, picture: str, command: str) -> str:
        """Return the page for `docs`."""
        from nlds_vines.accuracy import comparison_page as tables
        from nlds_vines.accuracy.comparison_table import read_comparison

        return tables.page(read_comparison(view), picture, command, self.want)


@dataclass(frozen=True)
class Stiffened:
    """One system with its contact made softer and harder; `rivals` as in `Compared`."""

    system: System
    periods: int
    rivals: tuple[Rival, ...] | None
    default: str = "stiffness.h5"

    def survey(self) -> Survey:
        """Return the measurements of every method at every stiffness."""
        from nlds_vines.accuracy.stiffness import stiffness

        return stiffness(self.system, self.periods, _there(self.rivals))

    def draw(self, view: ArchiveView) -> Figure:
        """Return error and cost against K."""
        from nlds_vines.accuracy.picture import draw_stiffness
        from nlds_vines.accuracy.stiffness_table import read_stiffness

        return draw_stiffness(read_stiffness(view))

    def lines(self, view: ArchiveView) -> Iterator[str]:
        """Yield the tables of all stiffnesses."""
        from nlds_vines.accuracy import stiffness_table as tables

        return tables.lines(tables.read_stiffness(view))

    def page(self, view: ArchiveView, picture: str, command: str) -> str:
        """Return the page for `docs`."""
        from nlds_vines.accuracy import stiffness_table as tables

        return tables.page(tables.read_stiffness(view), picture, command)


def _there(rivals: tuple[Rival, ...] | None) -> tuple[Rival, ...]:
    """Return the package's rivals and those given that are installed; none for None."""
    from nlds_vines.accuracy.rivals import RIVALS, installed

    return () if rivals is None else installed((*RIVALS, *rivals))


def mode_of(options: Any, system: System, rivals: tuple[Rival, ...] = ()) -> Mode:
    """Return what the options ask for, with `rivals` beside those of the package.

    Raises `RequestError` for options that do not go together.
    """
    periods, want = None, None
    if options.periods is not None:
        periods = whole("--periods", from_text(int, "--periods", options.periods), 2, 10_000)
    if options.want is not None:
        want = from_text(float, "--want", options.want)
        if not 0.0 < want < 1.0:
            raise RequestError(f"--want = {want:g} must lie between 0 and 1")
    chosen = None if options.no_peers else rivals
    if not options.stiff:
        if options.suite and (options.scan or options.system or options.set):
            raise RequestError("--suite has cases of its own: leave out the system and --set")
        return Compared(system, periods, want, options.suite, chosen)
    if want is not None:
        raise RequestError("--want advises on error against run time: leave it out with --stiff")
    if not system.scene.walls:
        raise RequestError(f"--stiff: kind {system.kind!r} has no contact to make stiff")
    return Stiffened(system, periods or 20, chosen)
