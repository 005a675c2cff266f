"""The requests of the paper's figures and of studies: what each picture needs, by its file.

A file with `[[curves]]` is a request of response curves, one with a `[portrait]` table that of one
orbit in full, and any other that of a scan.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path

from nlds_vines.archives.files import read_toml
from nlds_vines.bifurcation.request import Scan, load_scan
from nlds_vines.bifurcation.response_curves import CurveRequest, load_curves
from nlds_vines.errors import at, string
from nlds_vines.model.catalog import catalog, figure_files


@dataclass(frozen=True)
class FigureRequest:
    """What a picture needs.

    Attributes:
        path: of the TOML file.
        title: of the picture.
        computed: the request of its archive; None for a portrait, which has none here.
    """

    path: Path
    title: str
    computed: CurveRequest | Scan | None = None

    @property
    def name(self) -> str:
        """The name of picture and file, `figure2a`."""
        return self.path.stem

    @property
    def scans(self) -> dict[str, Scan]:
        """The scans of all cases by name, see `case_name`; of a diagram or map itself alone."""
        if isinstance(self.computed, CurveRequest):
            return {case_name(case.scan): case.scan for case in self.computed.cases}
        return {} if self.computed is None else {case_name(self.computed): self.computed}

    @property
    def archive(self) -> str:
        """The name of its archive, which changes with anything that is computed; empty for none."""
        return "" if self.computed is None else f"{self.name}-{self.computed.hash[:10]}.h5"


def case_name(scan: Scan) -> str:
    """Return the name of a scan's system, and the parameters that are not as in the catalog.

    So `tmd_k2=2083_c2=112` is a tuned mass damper with two values of its own.
    """
    system = scan.system
    usual = catalog()[system.name].parameters if system.name in catalog() else {}
    changed = {key: value for key, value in system.parameters.items() if usual.get(key) != value}
    return "_".join([system.name, *(f"{key}={value:g}" for key, value in changed.items())])


def short_name(name: str) -> str:
    """Return the name of a request on the command line: `2a` for figure2a."""
    return name.removeprefix("figure").removeprefix("study-")


def packaged_figures() -> dict[str, FigureRequest]:
    """Return the requests of all packaged files, by short name, figures before studies."""
    paths = {short_name(path.stem): path for path in sorted(figure_files(), key=_order)}
    return {name: load_figure(path) for name, path in paths.items()}


def _order(path: Path) -> tuple[bool, int, str]:
    """Return the key to sort by: figures by their numbers, then everything else."""
    number = re.match(r"figure(\d+)", path.stem)
    return number is None, int(number[1]) if number else 0, path.stem


def load_figure(path: Path) -> FigureRequest:
    """Return the request in a TOML file, checked throughout.

    Raises `RequestError`, one line that names file, place and key.
    """
    document = read_toml(path)
    if "portrait" in document:  # its own command reads and checks it
        with at(str(path)):
            return FigureRequest(path, string("title", document.get("title", path.stem)))
    computed = load_curves(path) if "curves" in document else load_scan(path)
    return FigureRequest(path, computed.title, computed)
