"""A figure written to a file, whole or not at all, with its origin; or shown in a notebook."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeVar

import matplotlib
from matplotlib.figure import Figure

from nlds_vines.archives.archive import ArchiveView
from nlds_vines.archives.files import in_one_line, whole
from nlds_vines.errors import MOST_CHARACTERS, RequestError, printable
from nlds_vines.plotting.page import styled
from nlds_vines.runs.progress import in_notebook

Drawn = TypeVar("Drawn")

FORMATS = {"png": 200, "pdf": 600, "svg": 600}
"""The formats of a picture, by the suffix of its name, each with its resolution in dots per inch.

In the vector formats only clouds of dots and shaded cells have a resolution."""


def drawn(view: ArchiveView, draw: Callable[[ArchiveView], Drawn]) -> Drawn:
    """Return the figure of an archive, or what is said of it, as `draw` makes it.

    Raises `RequestError` where the content of the archive does not fit together.
    """
    try:
        return draw(view)
    except RequestError:
        raise
    except (ValueError, LookupError, TypeError, ArithmeticError, AttributeError) as error:
        reason = (str(error).splitlines() or [""])[0]
        raise RequestError(
            f"{view.path} is complete, but cannot be drawn: {type(error).__name__}: {reason}"
        ) from error


def check_format(path: Path) -> str:
    """Return the format that a picture's suffix means; `RequestError` if it is not in `FORMATS`."""
    form = path.suffix.lower().removeprefix(".")
    if form not in FORMATS:
        raise RequestError(f"{path}: a picture is one of .{', .'.join(FORMATS)}")
    return form


def save_figure(figure: Figure, path: Path, title: str, origin: tuple[str, str]) -> Path:
    """Save a figure, completely or not at all, and return its path.

    Arguments: the `figure`; its `path`, whose suffix chooses one of `FORMATS`; for the metadata its
    `title` and its `origin`, the name and the value of a hash.

    Raises `RequestError` for another suffix and for a place that cannot be written.
    """
    form, (name, digest) = check_format(path), origin
    # matplotlib names the elements of an SVG at random unless it is given a salt
    salt: dict[Any, Any] = {"svg.hashsalt": digest}
    title = printable(title[:MOST_CHARACTERS])
    with in_one_line(f"write {path}"), styled(), matplotlib.rc_context(salt):
        metadata = _metadata(form, title, name, digest)
        with whole(path) as temporary:
            figure.savefig(temporary, format=form, dpi=FORMATS[form], metadata=metadata)
    return path


def _metadata(form: str, title: str, name: str, digest: str) -> dict[str, str | None]:
    """Return title and origin under the keys of a format; no date, so that the bytes repeat."""
    origin = f"{name} {digest}"
    if form == "png":
        return {"Title": title, name: digest}
    if form == "pdf":
        return {"Title": title, "Subject": origin, "CreationDate": None}
    return {"Title": title, "Description": origin, "Date": None}


# ---- in notebooks --------------------------------------------------------------------------------


def let_figures_be_shown() -> None:
    """Let a notebook show figures that its cells return; elsewhere nothing happens.

    A notebook learns to do so when matplotlib.pyplot is loaded, which this program never does.
    """
    if in_notebook():
        from IPython import get_ipython
        from IPython.core.pylabtools import select_figure_formats

        select_figure_formats(get_ipython(), {"png"})
