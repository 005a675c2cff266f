"""The table of error against run time: its columns, and an archive of it read case by case."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from nlds_vines.accuracy.curves import Curve
from nlds_vines.accuracy.results import Result, Setting, column, status_column
from nlds_vines.archives.archive import ArchiveView

SHAPE = "error against run time"

COLUMNS = (
    column("case", "str", "1", "what was followed"),
    column("title", "str", "1", "the same in words"),
    column("truth", "str", "1", "regime of the orbit, by both methods"),
    column("source", "str", "1", "where the reference comes from"),
    column("doubt", "float64", "m, m/s", "errors below this cannot be told from none"),
    column("independent", "float64", "m, m/s", "distance of the reference from its witness"),
    column("witness", "str", "1", "independent program that confirms it, and its setting"),
    column("growth", "float64", "1", "growth of a disturbance of the start until the end"),
    column("periods", "int32", "1", "forcing periods after which the error is taken"),
    column("method", "str", "1", "integrator"),
    column("setting", "str", "1", "its setting in words"),
    column("value", "float64", "1", "its setting: nodes, steps of a period, or rtol"),
    column("ours", "int8", "1", "1: of this program"),
    column("expected_order", "float64", "1", "order that the method has on smooth equations"),
    column("error", "float64", "m, m/s", "of the last state, the largest of its components"),
    column("touch_error", "float64", "s", "of the times of touch, the largest"),
    column("missed", "float64", "1", "touches missed; negative: invented"),
    column("energy_error", "float64", "J", "of E1max over the last half of the periods"),
    column("label", "str", "1", "regime by recurrence, begun on the true orbit"),
    column("seconds", "float64", "s", "CPU time per forcing period, of all threads"),
    column("failure", "str", "1", "why there is no measurement"),
    status_column(),
)


@dataclass(frozen=True)
class Measured:
    """What an archive says of one case: its words and numbers, and a curve for each method."""

    name: str
    title: str
    truth: str
    source: str
    doubt: float
    independent: float
    witness: str
    growth: float
    periods: int
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
    rows = np.flatnonzero(table["case"] == name)
    first = {column: values[rows[0]] for column, values in table.items()}
    results = [_result({column: values[i] for column, values in table.items()}) for i in rows]
    methods = dict.fromkeys(found.setting.method for found in results)
    doubt = float(first["doubt"])
    curves = tuple(Curve(method, tuple(_of(method, results)), doubt) for method in methods)
    return Measured(
        name=name,
        title=str(first["title"]),
        truth=str(first["truth"]),
        source=str(first["source"]),
        doubt=doubt,
        independent=float(first["independent"]),
        witness=str(first["witness"]),
        growth=float(first["growth"]),
        periods=int(first["periods"]),
        curves=curves,
    )


def _of(method: str, results: Sequence[Result]) -> Iterator[Result]:
    return (found for found in results if found.setting.method == method)


def _result(row: dict[str, Any]) -> Result:
    """Return a row as the result that it came from."""
    setting = Setting(
        method=str(row["method"]),
        value=float(row["value"]),
        words=str(row["setting"]),
        ours=bool(row["ours"]),
        order=float(row["expected_order"]),
    )
    return Result(
        setting=setting,
        error=float(row["error"]),
        touch_error=float(row["touch_error"]),
        missed=float(row["missed"]),
        energy_error=float(row["energy_error"]),
        label=str(row["label"]),
        seconds=float(row["seconds"]),
        failure=str(row["failure"]),
    )
