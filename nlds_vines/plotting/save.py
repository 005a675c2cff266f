"""A figure saved in one of the formats, with its origin in its metadata."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path
from typing import Any

import matplotlib
from matplotlib.figure import Figure

from nlds_vines.archives.archive import ArchiveView, read
from nlds_vines.archives.durable import in_one_line
from nlds_vines.errors import RequestError
from nlds_vines.plotting.style import STYLE

FORMATS = {"png": 200, "pdf": 600, "svg": 600}
"""What a picture may be, by the suffix of its name, and its resolution in dots per inch; in the
vector formats that of the clouds of dots alone."""


def save_drawn(
    archive_path: str | os.PathLike[str],
    plot_path: str | os.PathLike[str],
    draw: Callable[[ArchiveView], Figure],
) -> Path:
    """Open an archive, `draw` it and save the picture; returns the picture's path.

    The suffix of `plot_path` chooses the format, one of `FORMATS`.  The picture takes its name only
    when it is whole, carries the hash of what was asked for in its metadata, and has the same bytes
    whenever it is drawn from the same archive.

    Raises `RequestError` for another suffix, for an archive that cannot be read or holds nothing
    to draw, and for a place that cannot be written.
    """
    path = Path(plot_path)
    check_format(path)
    with read(archive_path) as view:
        figure = draw(view)
        title, scan_hash = str(view.attrs["title"]), str(view.attrs["scan_hash"])
    return save_figure(figure, path, title, ("scan_hash", scan_hash))


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


def _metadata(form: str, title: str, name: str, digest: str) -> dict[str, str | None]:
    """Return title and origin in the words of each format; without a date, so that bytes repeat."""
    origin = f"{name} {digest}"
    if form == "png":
        return {"Title": title, name: digest}
    if form == "pdf":
        return {"Title": title, "Subject": origin, "CreationDate": None}
    return {"Title": title, "Description": origin, "Date": None}
