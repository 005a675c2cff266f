"""Archive -> picture: diagrams, maps of regimes, pages of curves, from archives alone.

Nothing is computed here, and no kernel is ever loaded.  The only part that imports matplotlib.
"""

from __future__ import annotations

import os
from collections.abc import Callable
from hashlib import sha256
from pathlib import Path
from typing import Any

import matplotlib
from matplotlib.figure import Figure

from nlds_vines.archive import ArchiveView, read
from nlds_vines.durable import in_one_line
from nlds_vines.errors import RequestError
from nlds_vines.figures.curves import draw_page
from nlds_vines.figures.diagram import diagram
from nlds_vines.figures.maps import regime_map
from nlds_vines.figures.style import STYLE
from nlds_vines.figures.surface import tuning_surface
from nlds_vines.pages import Curve, Page
from nlds_vines.shows import check_show

__all__ = [
    "FORMATS",
    "diagram",
    "draw_page",
    "regime_map",
    "save",
    "save_figure",
    "save_page",
    "tuning_surface",
]

FORMATS = {"png": 200, "pdf": 600, "svg": 600}
"""What a picture may be, by the suffix of its name, and its resolution in dots per inch; in the
vector formats that of the clouds of dots alone."""


def save(
    archive_path: str | os.PathLike[str],
    plot_path: str | os.PathLike[str],
    show: str | None = None,
) -> Path:
    """Draw what an archive holds: one varied parameter, two, or the surface of a tuning.

    `show` says what a map shall show (see `regime_map`).  The suffix of `plot_path` chooses the
    format, one of `FORMATS`.  The picture takes its name only when it is whole, carries the scan's
    hash in its metadata, and has the same bytes whenever it is drawn from the same archive.
    Returns its path.

    Raises `RequestError` for another suffix, for an archive that cannot be read or holds nothing
    to draw, and for a place that cannot be written.
    """
    path = Path(plot_path)
    check_format(path)
    with read(archive_path) as view:
        figure = _figure(view, show)
        title, scan_hash = str(view.attrs["title"]), str(view.attrs["scan_hash"])
    return save_figure(figure, path, title, ("scan_hash", scan_hash))


def save_page(
    recipe: Page, archive_of: Callable[[Curve], Path], plot_path: str | os.PathLike[str]
) -> Path:
    """Draw a page of curves as `save` draws an archive; returns the picture's path.

    Arguments: `archive_of` returns the path of a curve's archive.  The hash in the picture is
    that of all its scans.
    """
    path = Path(plot_path)
    check_format(path)
    figure = draw_page(recipe, archive_of)
    hashes = "".join(curve.scan.hash for curve in recipe.curves)
    origin = ("scan_hash", sha256(hashes.encode()).hexdigest())
    return save_figure(figure, path, recipe.title, origin)


def check_format(path: Path) -> str:
    """Return the format that a picture's suffix means; raises `RequestError` for another one."""
    form = path.suffix.lower().removeprefix(".")
    if form not in FORMATS:
        raise RequestError(f"{path}: a picture is one of .{', .'.join(FORMATS)}")
    return form


def save_figure(figure: Figure, path: Path, title: str, origin: tuple[str, str]) -> Path:
    """Save a figure with its title and its `origin`, the name and value of a hash; same manners.

    Raises `RequestError` for another suffix and for a place that cannot be written.
    """
    form, (name, digest) = check_format(path), origin
    temporary = path.with_name(f"{path.name}.tmp")
    # without salt of one's own, the names inside an SVG are drawn by lot
    salt: dict[Any, Any] = {"svg.hashsalt": digest}
    with in_one_line(f"write {path}"), matplotlib.rc_context({**STYLE, **salt}):
        try:
            metadata = _metadata(form, title, name, digest)
            figure.savefig(temporary, format=form, dpi=FORMATS[form], metadata=metadata)
            os.replace(temporary, path)
        finally:
            temporary.unlink(missing_ok=True)
    return path


def _figure(view: ArchiveView, show: str | None) -> Figure:
    if view.attrs.get("content") == "tuning":
        return tuning_surface(view)
    if show is not None:
        check_show(show, len(view.axes), view["start"].size, view.names)
    return diagram(view) if len(view.axes) == 1 else regime_map(view, show)


def _metadata(form: str, title: str, name: str, digest: str) -> dict[str, str | None]:
    """Return title and origin in the words of each format; without a date, so that bytes repeat."""
    origin = f"{name} {digest}"
    if form == "png":
        return {"Title": title, name: digest}
    if form == "pdf":
        return {"Title": title, "Subject": origin, "CreationDate": None}
    return {"Title": title, "Description": origin, "Date": None}
