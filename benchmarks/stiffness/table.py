"""The table of stiffness: its columns, an archive of it read, and what it says in Markdown."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Annotated, Any

import numpy as np

from nlds_vines.accuracy.measured_cases import Known, Result, Setting
from nlds_vines.accuracy.picture import family_of
from nlds_vines.accuracy.tables import duration
from nlds_vines.archives.archive import ArchiveView
from nlds_vines.archives.record_columns import Column, columns
from nlds_vines.cli.markdown_tables import table

SHAPE = "stiffness"


@dataclass(frozen=True)
class Stiffened:
    """One stiffness of the contact, and the true orbit with it."""

    K: Annotated[float, Column("N/m^1.5", "contact stiffness")]
    E2: Annotated[
        float, Column("Pa", "Young's modulus of the damper's side, where K follows from it")
    ]
    touches: Annotated[int, Column("1", "touches there are")]
    rigid: Annotated[float, Column("m, m/s", "distance of the true state from the rigid limit's")]
    steps: Annotated[
        float, Column("1", "steps, or nodes, of a contact: ours as set, others' counted")
    ] = math.nan


_UNUSED = "case title truth periods source independent witness value expected_order"

COLUMNS = columns(Stiffened, Known, Setting, Result, without=_UNUSED.split())

_PAGE = """\
# Stiff contacts

Made by the command at the end of this page. The contact of one system is made softer and harder,
through Young's modulus of the damper's side and through K itself, far beyond any material; every
method follows the orbit from rest. A contact lasts as K^(-2/5), and its force rises as K^(2/5): a
step that knows nothing of it must shrink with it or fail. `exact` solves a short contact in its own
units, so that neither its error nor its cost grows with K; soft and long contacts are stepped. In
the picture, what leaves the frame has diverged.

![Error and cost against K]({picture})

{tables}

From the paper's K upwards, the dearest period of `exact` costs {ratio:.2f} times one at the
paper's K.

```sh
{command}
```
"""

_OURS = (
    *("K [N/m^1.5]", "error", "growth", "touches", "missed", "steps a contact"),
    *("CPU per period", "to the rigid limit"),
)
_OTHERS = (
    *("peer", "setting", "largest error", "at K", "missed", "invented", "steps a contact"),
    *("dearest period", "failed"),
)

_STIFF = 1e9  # K from which on the law of the rigid limit is fitted
_SOFT = 3e7  # K of the paper's rubber: the soft case that harder ones are compared with


@dataclass(frozen=True)
class Stiff:
    """What a survey of stiffness found: arrays by column, a row for each method and stiffness."""

    title: str
    table: dict[str, np.ndarray]

    @property
    def methods(self) -> list[str]:
        """The integrators, ours first."""
        return list(dict.fromkeys(self.table["method"].tolist()))

    def of(self, method: str) -> dict[str, np.ndarray]:
        """Return the rows of a method, by ascending K."""
        rows = np.flatnonzero(self.table["method"] == method)
        rows = rows[np.argsort(self.table["K"][rows], kind="stable")]
        return {name: values[rows] for name, values in self.table.items()}

    @property
    def exponent(self) -> float:
        """The observed exponent in K of the distance to the rigid limit; -2/5 is expected."""
        rows = self.of("exact")
        stiff = (rows["K"] >= _STIFF) & np.isfinite(rows["rigid"])
        if stiff.sum() < 3:
            return math.nan
        return float(np.polyfit(np.log(rows["K"][stiff]), np.log(rows["rigid"][stiff]), 1)[0])

    @property
    def cost_ratio(self) -> float:
        """The largest cost of `exact` at any K from `_SOFT` on, over that at the first of them."""
        rows = self.of("exact")
        hard = rows["seconds"][(rows["K"] >= _SOFT) & (rows["status"] == 0)]
        return float(hard.max() / hard[0]) if hard.size else math.nan


def read_stiffness(view: ArchiveView) -> Stiff:
    """Return what an archive of such a survey holds."""
    return Stiff(view.text("title"), {name: view[name] for name in view.names})


def lines(found: Stiff, methods: Sequence[str] | None = None) -> Iterator[str]:
    """Yield the tables: ours in full, then where and how each rival fails."""
    if math.isfinite(found.exponent):
        yield f"The distance to the rigid limit falls as K^{found.exponent:.3f} (expected: K^-0.4)."
    else:
        yield "There is no rigid limit of isolated impacts to compare with."
    yield ""
    for method in ("exact", "rk4"):
        yield from table((f"{method}: E2 [Pa]", *_OURS), _rows(found.of(method)), range(9))
        yield ""
    rows = (_summary(found.of(method), method) for method in methods or found.methods[2:])
    yield from table(_OTHERS, rows, range(2, 8))


def representatives(found: Stiff) -> list[str]:
    """Return of each family of solvers the one that fails least, and of these the most exact."""

    def badness(method: str) -> tuple[int, float]:
        rows = found.of(method)
        return int(rows["status"].sum()), float(np.nanmax(rows["error"], initial=0.0))

    best: dict[str, str] = {}
    for method in found.methods:
        family = family_of(method)
        best[family] = min(best.get(family, method), method, key=badness)
    return list(best.values())


def _rows(found: dict[str, np.ndarray]) -> Iterator[tuple[str, ...]]:
    """Yield the cells of one of our methods, a row for each stiffness."""
    for i in range(len(found["K"])):
        row = {name: values[i] for name, values in found.items()}
        modulus = "" if math.isnan(row["E2"]) else f"{row['E2']:.3g}"
        yield modulus, f"{row['K']:.2e}", *_cells(row)


def _cells(row: dict[str, Any]) -> tuple[str, ...]:
    if row["failure"]:
        return (f"failed: {row['failure']}",)
    return (
        f"{row['error']:.1e}",
        f"{row['growth']:.2g}",
        f"{row['touches']}",
        _digits(row["missed"]),
        _digits(row["steps"]),
        duration(row["seconds"]),
        f"{row['rigid']:.1e}",
    )


def _summary(rows: dict[str, np.ndarray], method: str) -> tuple[str, ...]:
    """Return the cells of a solver of others: its worst over all stiffnesses."""
    done, setting = rows["status"] == 0, str(rows["setting"][0])
    if not done.any():
        return method, setting, *[""] * 6, f"everywhere: {rows['failure'][0]}"
    worst = int(np.argmax(np.where(done, rows["error"], -np.inf)))
    failed = zip(rows["K"][~done], rows["failure"][~done], strict=True)
    return (
        method,
        setting,
        f"{rows['error'][worst]:.1e}",
        f"{rows['K'][worst]:.1e}",
        _sum(rows["missed"][done], 1),
        _sum(rows["missed"][done], -1),
        _counted(rows["steps"]),
        duration(float(rows["seconds"][done].max())),
        "; ".join(f"K = {K:.0e}: {why}" for K, why in failed),
    )


def _digits(value: float) -> str:
    return "" if math.isnan(value) else f"{float(f'{value:.3g}'):g}"


def _counted(steps: np.ndarray) -> str:
    """Return the range of the steps of a contact; empty if they were not counted."""
    known = steps[np.isfinite(steps)]
    return f"{known.min():.0f} to {known.max():.0f}" if known.size else ""


def _sum(missed: np.ndarray, sign: int) -> str:
    """Return how many touches were missed (1) or invented (-1) in all; empty if not known."""
    if np.isnan(missed).all():
        return ""
    return f"{np.nansum(np.maximum(sign * missed, 0.0)):g}"


def page(found: Stiff, picture: str, command: str) -> str:
    """Return the page of a survey of stiffness: the picture, the tables, the command."""
    return _PAGE.format(
        picture=picture, tables="\n".join(lines(found)), ratio=found.cost_ratio, command=command
    )
