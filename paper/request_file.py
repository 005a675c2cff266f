"""The request files of the paper's figures and of studies (TOML), read and checked."""

from __future__ import annotations

import re
from pathlib import Path

from nlds_vines.archives.files import read_toml
from nlds_vines.bifurcation.request_file import load_scan
from nlds_vines.bifurcation.response_curves.request_file import load_page
from nlds_vines.errors import at, string
from nlds_vines.model.catalog import figure_files
from nlds_vines.model.request_layers import Document
from paper.request import FigureRequest, short_name


def packaged_figures() -> dict[str, FigureRequest]:
    """Return the requests of all packaged files, by short name, figures before studies."""
    found = {short_name(path.stem): path for path in sorted(figure_files(), key=_order)}
    return {name: load_figure(path) for name, path in found.items()}


def load_figure(path: Path) -> FigureRequest:
    """Return the request in a TOML file, checked throughout.

    Raises `RequestError`, one line that names file, place and key.
    """
    document = read_toml(path)
    if "portrait" in document:  # its own command reads and checks it
        return FigureRequest(path, "portrait", _title(path, document))
    if "curves" in document:
        page = load_page(path)
        return FigureRequest(path, "curves", page.title, page=page)
    scan = load_scan(path)
    return FigureRequest(path, "scan", scan.title, scan=scan)


def _order(path: Path) -> tuple[bool, int, str]:
    """Return what to sort by: figures by their numbers, then everything else."""
    number = re.match(r"figure(\d+)", path.stem)
    return number is None, int(number[1]) if number else 0, path.stem


def _title(path: Path, document: Document) -> str:
    with at(str(path)):
        return string("title", document.get("title", path.stem))
