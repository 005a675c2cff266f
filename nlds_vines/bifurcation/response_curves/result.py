"""Response curves as an archive holds them, case by case, and in words."""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np

from nlds_vines.archives.archive import ArchivePath, ArchiveView, read
from nlds_vines.archives.provenance import RESPONSE_CURVES
from nlds_vines.archives.representation import Outlined
from nlds_vines.bifurcation.response_curves.request import CurveRequest, load_curves
from nlds_vines.errors import RequestError, shown
from nlds_vines.model.linear_response import energy_alone
from nlds_vines.model.parameters import described
from nlds_vines.plotting.drawable import Drawable


@dataclass(frozen=True, repr=False)
class ResponseCurve(Outlined):
    """The results along the curve of one case.

    Attributes
    ----------
    name : str
        The name of the case.
    values : (n,) ndarray
        The parameter along the curve.
    numbers : dict of (n, starts) ndarray
        The recorded quantities by name; of two walls the larger value.
    peak_alone : float
        The highest E1max of the structure alone in closed form [J]; NaN without a damper.
    """

    name: str
    values: np.ndarray
    numbers: Mapping[str, np.ndarray]
    peak_alone: float = np.nan

    def __getitem__(self, name: str) -> np.ndarray:
        """Return a recorded quantity (n,) of the first start; `RequestError` for another name."""
        if name not in self.numbers:
            allowed = ", ".join(self.numbers)
            raise RequestError(f"{shown(name)} is not recorded along curves; allowed: {allowed}")
        return self.numbers[name][:, 0]

    @property
    def E1max(self) -> np.ndarray:
        """Largest energies of the structure [J], (n,)."""
        return self["E1max"]

    @property
    def peak(self) -> float:
        """The highest E1max, of all starts [J]; NaN if none is finite."""
        return float(np.fmax.reduce(self.numbers["E1max"], axis=None))

    @property
    def peak_at(self) -> float:
        highest = np.fmax.reduce(self.numbers["E1max"], axis=1)
        return float(self.values[np.nanargmax(highest)]) if np.isfinite(self.peak) else np.nan

    @property
    def peak_reduction(self) -> float:
        """1 - peak / peak of the structure alone; NaN without a damper."""
        return 1.0 - self.peak / self.peak_alone if self.peak_alone else np.nan

    @property
    def failed(self) -> int:
        return int(np.count_nonzero(self.numbers["status"] > 0)) if "status" in self.numbers else 0

    def cycles(self, start: int = 0) -> np.ndarray:
        """Return n,k of each nT,k as text, "" for no period; (0,) if no impacts are recorded."""
        n, k = (self.numbers.get(name) for name in ("periodicity", "impact_count"))
        if n is None or k is None or (k < 0).all():  # without walls
            return np.empty(0, dtype=np.str_)
        pairs = zip(n[:, start], k[:, start], strict=True)
        return np.array([f"{one},{of}" if one > 0 else "" for one, of in pairs])


@dataclass(frozen=True, repr=False)
class ResponseCurves(Drawable):
    """The response curves in an archive.

    Attributes
    ----------
    path : ArchivePath
    request : CurveRequest
        The request; computed again, it gives the same numbers.
    curves : tuple of ResponseCurve
        The results of each case, in the order of `request.cases`; `curves["TMD"]` by name.
    """

    drawn_by = "nlds_vines.bifurcation.response_curves.picture"

    path: ArchivePath
    request: CurveRequest
    curves: tuple[ResponseCurve, ...]

    @property
    def failed(self) -> int:
        """Number of orbits that failed."""
        return sum(curve.failed for curve in self.curves)

    def __getitem__(self, name: str) -> ResponseCurve:
        """Return the curve of a case; `RequestError` for another name."""
        by_name = {curve.name: curve for curve in self.curves}
        if name not in by_name:
            allowed = ", ".join(by_name)
            raise RequestError(f"case = {shown(name)} is not there; allowed: {allowed}")
        return by_name[name]

    def lines(self) -> Iterator[str]:
        """Yield the title and a line for each curve: its peak, and the reduction of the peak."""
        yield self.request.title
        axis = self.request.cases[0].scan.axes[0]
        stated = axis.as_stated  # f [Hz] in place of omega, if the request has it
        unit, factor = described(stated.name).unit, stated.values[-1] / axis.values[-1]
        for curve in self.curves:
            at = factor * curve.peak_at
            text = f"{curve.name}: peak {curve.peak:.5g} J at {stated.name} = {at:g}"
            text += f" {unit}" if unit != "1" else ""
            if np.isfinite(curve.peak_reduction):
                lower = "lower" if curve.peak_reduction >= 0 else "higher"
                percent = 100 * abs(curve.peak_reduction)
                text += f", {percent:.1f} % {lower} than that of the structure alone"
            yield text + (f"; {curve.failed} orbits failed" if curve.failed else "")


def curves_in(path: str | os.PathLike[str]) -> ResponseCurves:
    with read(path) as view:
        return curves_of(view)


def curves_of(view: ArchiveView) -> ResponseCurves:
    """Return the response curves in an open archive; `RequestError` for another archive."""
    request = view.request(RESPONSE_CURVES, load_curves)
    dims = ("case", request.axis, "start")
    curves = []
    for i, (name, case) in enumerate(zip(request.names, request.cases, strict=True)):
        numbers = {}
        for key in (key for key in view.names if view.dims(key)[:3] == dims):
            values = view[key][i]
            by_wall = values.ndim > 2
            numbers[key] = np.fmax.reduce(values, axis=-1) if by_wall else values
        damped = case.scan.system.scene.damper
        alone = float(energy_alone(case.scan.cells()).max()) if damped else np.nan
        curves.append(ResponseCurve(name, request.values, numbers, alone))
    return ResponseCurves(ArchivePath.of(view.path), request, tuple(curves))
