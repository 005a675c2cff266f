"""The table of error against run time: its columns, and an archive of it read case by case."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

import numpy as np

from nlds_vines.accuracy.columns import Column, columns, record_of
from nlds_vines.accuracy.curves import Curve
from nlds_vines.accuracy.results import Known, Result, Setting
from nlds_vines.archives.archive import ArchiveView

SHAPE = "error against run time"


@dataclass(frozen=True)
class Followed:
    """What was followed: a case in words and numbers."""

    name: Annotated[str, Column("1", "what was followed", "case")]
    title: Annotated[str, Column("1", "the same in words")]
    truth: Annotated[str, Column("1", "regime of the orbit, by both methods")]
    periods: Annotated[int, Column("1", "forcing periods after which the error is taken")]


COLUMNS = columns(Followed, Known, Setting, Result, without=("steps",))


@dataclass(frozen=True)
class Measured(Known, Followed):
    """What an archive says of one case: its words and numbers, and a curve for each method."""

    curves: tuple[Curve, ...]

    @property
    def results(self) -> list[Result]:
        """All results, in order."""
        return [found for curve in self.curves for found in curve.results]

    def curve(self, method: str) -> Curve:
        """Return the curve of a method."""
        return next(curve for curve in self.curves if curve.method == method)


def read_comparison(view: ArchiveView) -> list[Measured]:
    """Return what an archive of such a survey holds, case by case."""
    table = {name: view[name] for name in view.names}
    names = dict.fromkeys(table["case"].tolist())
    return [_measured(name, table) for name in names]


def _measured(name: str, table: dict[str, np.ndarray]) -> Measured:
    places = np.flatnonzero(table["case"] == name)
    rows = [{column: values[i] for column, values in table.items()} for i in places]
    results: dict[str, list[Result]] = {}
    for row in rows:
        found = record_of(Result, row, setting=record_of(Setting, row))
        results.setdefault(found.setting.method, []).append(found)
    doubt = float(rows[0]["doubt"])
    curves = tuple(Curve(method, tuple(found), doubt) for method, found in results.items())
    return record_of(Measured, rows[0], curves=curves)
