"""A page of curves of the paper, drawn from the archives of its scans: one for each curve."""

from __future__ import annotations

from collections.abc import Callable
from hashlib import sha256
from pathlib import Path

from nlds_vines.archives.archive import read
from nlds_vines.bifurcation.response_curves.picture import draw_page
from nlds_vines.bifurcation.response_curves.request import Curve, CurvePage, label_of
from nlds_vines.bifurcation.response_curves.result import CurveValues
from nlds_vines.plotting.save import check_format, save_figure


def save_page(page: CurvePage, archive_of: Callable[[Curve], Path], plot_path: Path) -> Path:
    """Draw a page of curves, save it and return the picture's path.

    Arguments: the `page`; `archive_of` returns the path of a curve's archive; `plot_path`, whose
    suffix is one of `plotting.save.FORMATS`.  The hash in the picture is that of all its scans.

    Raises `RequestError` for archives without the energies, and as `save_figure` does.
    """
    check_format(plot_path)
    figure = draw_page(page, values_of(page, archive_of))
    hashes = "".join(curve.scan.hash for curve in page.curves)
    origin = ("scan_hash", sha256(hashes.encode()).hexdigest())
    return save_figure(figure, plot_path, page.title, origin)


def values_of(page: CurvePage, archive_of: Callable[[Curve], Path]) -> list[CurveValues]:
    """Return what the archives of a page's scans hold along its curves."""
    return [_values(curve, archive_of(curve)) for curve in page.curves]


def _values(curve: Curve, path: Path) -> CurveValues:
    """Return what a scan's archive holds along a curve."""
    with read(path) as view:
        names = [
            "E1max",
            *(name for name in ("E2max", "impact_count", "periodicity") if name in view),
        ]
        numbers = {name: view.take(name, start=0) for name in names}
        return CurveValues(label_of(curve), view[view.axes[0]], numbers)
