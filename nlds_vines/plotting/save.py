"""A figure saved to a file with its origin in the metadata, or shown in a notebook."""

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
"""The suffixes of pictures with their resolutions [dots per inch], of vector formats that of clouds
of dots and of shaded cells."""


def drawn(view: ArchiveView, draw: Callable[[ArchiveView], Drawn]) -> Drawn:
    """Return `draw(view)`; raise `RequestError` if the content of the archive is inconsistent."""
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
    """Return the format of a picture's suffix; `RequestError` if it is not in `FORMATS`."""
    form = path.suffix.lower().removeprefix(".")
    if form not in FORMATS:
        raise RequestError(f"{path}: a picture is one of .{', .'.join(FORMATS)}")
    return form


def save_figure(figure: Figure, path: Path, title: str, origin: tuple[str, str]) -> Path:
    """Save a figure, completely or not at all, and return its path.

    Arguments: its `path`, whose suffix chooses one of `FORMATS`; for the metadata its `title` and
    its `origin`, the name and the value of a hash.  The file has no date, so its bytes repeat.

    Raises `RequestError` for another suffix and for a path that cannot be written.
    """
    form, (name, digest) = check_format(path), origin
    # matplotlib names the elements of an SVG at random unless it is given a salt
    salt: dict[Any, Any] = {"svg.hashsalt": digest}
    title, words = printable(title[:MOST_CHARACTERS]), f"{name} {digest}"
    metadata: dict[str, dict[str, str | None]] = {
        "png": {"Title": title, name: digest},
        "pdf": {"Title": title, "Subject": words, "CreationDate": None},
        "svg": {"Title": title, "Description": words, "Date": None},
    }
    with in_one_line(f"write {path}"), styled(), matplotlib.rc_context(salt), whole(path) as part:
        figure.savefig(part, format=form, dpi=FORMATS[form], metadata=metadata[form])
    return path


def let_figures_be_shown() -> None:
    """Let a notebook show figures that its cells return, as matplotlib.pyplot would do."""
    if in_notebook():
        from IPython import get_ipython
        from IPython.core.pylabtools import select_figure_formats

        select_figure_formats(get_ipython(), {"png"})
