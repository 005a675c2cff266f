"""Response curves as an archive holds them: a curve for each damper, and what it says in words."""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np

from nlds_vines.archives.archive import ArchivePath, ArchiveView, read
from nlds_vines.archives.provenance import RESPONSE_CURVES
from nlds_vines.bifurcation.response_curves.curves_table import STATUSES
from nlds_vines.bifurcation.response_curves.request import CurvePage
from nlds_vines.bifurcation.response_curves.request_file import load_page
from nlds_vines.errors import RequestError, shown
from nlds_vines.model.parameters import PARAMETERS
from nlds_vines.model.representation import Outlined
from nlds_vines.plotting.drawable import Drawable


@dataclass(frozen=True, repr=False)
class CurveValues(Outlined):
    """What was computed along one curve, arrays (n,).

    Attributes:
        label: what a legend calls it.
        values: those of the parameter along the curve.
        numbers: all that was recorded along the curve, by name of the dataset; of a second start
            with the ending `_down`.
        peak, peak_at: the highest E1max [J], and the value of the parameter there.
        peak_reduction: 1 - peak / peak of the structure alone; NaN without that.
        failed: how many orbits failed.
    """

    label: str
    values: np.ndarray
    numbers: Mapping[str, np.ndarray]
    peak: float = np.nan
    peak_at: float = np.nan
    peak_reduction: float = np.nan
    failed: int = 0

    @property
    def E1max(self) -> np.ndarray:
        """Largest energies of the structure [J]; NaN where they were not recorded."""
        return self._along("E1max", np.nan)

    @property
    def E2max(self) -> np.ndarray:
        """Largest energies of the damper [J]; NaN without one."""
        return self._along("E2max", np.nan)

    @property
    def reduction(self) -> np.ndarray:
        """1 - E1max / E1max of the structure alone; NaN without a damper."""
        return self._along("reduction", np.nan)

    @property
    def impacts(self) -> np.ndarray:
        """Impacts per nT; -1 where they were not recorded."""
        return self._along("impact_count", -1)

    def periods(self, ending: str = "") -> np.ndarray:
        """Return n,k of each nT,k in words, "" where none was found; (0,) where none is recorded.

        Arguments: the `ending` of the names of a second start.
        """
        n, k = (self.numbers.get(name + ending) for name in ("periodicity", "impact_count"))
        if n is None or k is None or (k < 0).all():  # without walls
            return np.empty(0, dtype=np.str_)
        return np.array([f"{one},{of}" if one > 0 else "" for one, of in zip(n, k, strict=True)])

    def _along(self, name: str, nothing: float) -> np.ndarray:
        """Return a number along the curve; `nothing` everywhere where it was not recorded."""
        return self.numbers.get(name, np.full(self.values.size, nothing))


@dataclass(frozen=True, repr=False)
class ResponseCurves(Drawable):
    """The response curves in an archive.

    Attributes:
        path: of the archive.
        request: the page, with which the same numbers are computed again.
        curves: what was computed, in the order of `request.curves`.
    """

    drawn_by = "nlds_vines.bifurcation.response_curves.picture"

    path: ArchivePath
    request: CurvePage
    curves: tuple[CurveValues, ...]

    @property
    def failed(self) -> int:
        """How many orbits failed."""
        return sum(curve.failed for curve in self.curves)

    def __getitem__(self, label: str) -> CurveValues:
        """Return the curve of a label; `RequestError` where there is none."""
        found = next((curve for curve in self.curves if curve.label == label), None)
        if found is None:
            known = ", ".join(curve.label for curve in self.curves)
            raise RequestError(f"curve = {shown(label)} is not there; allowed: {known}")
        return found

    def lines(self) -> Iterator[str]:
        """Yield the title and a line for each curve: its peak, and the reduction of that."""
        yield self.request.title
        name, unit = self.request.axis, PARAMETERS[self.request.axis].unit
        for (place, _), curve in zip(self.request.places, self.curves, strict=True):
            panel = f"({chr(ord('a') + place)}) " if len(self.request.panels) > 1 else ""
            text = f"{panel}{curve.label}: peak {curve.peak:.5g} J at {name} = {curve.peak_at:g}"
            text += f" {unit}" if unit != "1" else ""
            if np.isfinite(curve.peak_reduction):
                text += f", {_in_words(curve.peak_reduction)} than that of the structure alone"
            yield text + (f"; {curve.failed} orbits failed" if curve.failed else "")


def _in_words(reduction: float) -> str:
    """Return a reduction in words: 72.1 % lower, or higher where it is negative."""
    return f"{abs(reduction):.1%} {'lower' if reduction >= 0 else 'higher'}".replace("%", " %")


def curves_in(path: str | os.PathLike[str]) -> ResponseCurves:
    """Return the response curves in an archive.

    Raises `RequestError` if it cannot be read, and for an archive of anything else.
    """
    with read(path) as view:
        return curves_of(view)


def curves_of(view: ArchiveView) -> ResponseCurves:
    """Return the response curves in an open archive; `RequestError` for one of anything else."""
    page = view.request(RESPONSE_CURVES, load_page)
    return ResponseCurves(ArchivePath.of(view.path), page, tuple(_curves(view, page)))


def _curves(view: ArchiveView, page: CurvePage) -> Iterator[CurveValues]:
    """Yield the curves of an archive."""
    every = {n: view[n] for n in view.names if view.dims(n) == ("curve", page.axis)}
    failed = sum(np.count_nonzero(every[n] > 0, axis=1) for n in STATUSES if n in every)
    peak, place, lower = view["peak"], view["peak_at"], view["peak_reduction"]
    for i, label in enumerate(view["label"]):
        yield CurveValues(
            label=str(label),
            values=view[page.axis],
            numbers={name: values[i] for name, values in every.items()},
            peak=float(peak[i]),
            peak_at=float(place[i]),
            peak_reduction=float(lower[i]),
            failed=int(failed[i]),
        )
