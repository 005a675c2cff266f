"""The request of a figure: what its picture needs, by the kind of its request file.

A file with `[[curves]]` is a page of response curves.  A scan file is the request file of its own
diagram or map, and a file with a `[portrait]` table that of one orbit in full.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path

from nlds_vines.bifurcation.request import Scan
from nlds_vines.bifurcation.response_curves.request import Curve, CurvePage, Panel

_MOST_LETTERS = 160  # of a name in that of an archive: file systems allow 255 bytes


@dataclass(frozen=True)
class FigureRequest:
    """What a picture needs.

    Arguments:
        path: of the TOML file.
        kind: `curves`, `scan` or `portrait`.
        title: of the picture.
        page: for `curves`; scan: for `scan`.
    """

    path: Path
    kind: str
    title: str
    page: CurvePage | None = None
    scan: Scan | None = None

    @property
    def name(self) -> str:
        """The name of picture and file, `figure2a`."""
        return self.path.stem

    @property
    def panels(self) -> tuple[Panel, ...]:
        """The panels: of a scan one, with one curve; of a portrait none."""
        if self.scan is not None:
            return (Panel((Curve(self.scan),)),)
        return () if self.page is None else self.page.panels

    @property
    def curves(self) -> tuple[Curve, ...]:
        """All curves, panel by panel."""
        return tuple(curve for panel in self.panels for curve in panel.curves)

    @property
    def archives(self) -> tuple[str, ...]:
        """The names of its archives."""
        return tuple(self.archive(curve) for curve in self.curves)

    def archive(self, curve: Curve) -> str:
        """Return the name of a curve's archive, which changes with anything that is computed.

        Curves that mean the same share it, on whatever page they stand.
        """
        stem = self.name if self.kind == "scan" else _file_name(curve.name)
        return f"{stem}-{curve.scan.hash[:10]}.h5"


def _file_name(name: str) -> str:
    """Return a name as a part of the name of a file: no folder stands in it, and it is not long."""
    return re.sub(r"[^\w.=+-]", "_", name, flags=re.ASCII)[:_MOST_LETTERS].lstrip(".")


def short_name(name: str) -> str:
    """Return what the command line calls a request: `2a` for figure2a, `stiffness` for a study."""
    return name.removeprefix("figure").removeprefix("study-")
