"""The request of a figure: the curves of a picture, and what to compute for them.

A request file with `[[curves]]` is a page of panels; every curve stands in every panel, and each
of the two may name a system and set parameters.  A scan file is the request file of its own diagram
or map, and a file with a `[portrait]` table that of one orbit in full.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

from nlds_vines.bifurcation.request import Scan
from nlds_vines.model.catalogue import catalogue
from nlds_vines.plotting.style import HUES

COLOURS: Mapping[str, str] = HUES
"""Colours by name, those of Okabe and Ito; a request file may also write `#rrggbb`."""

_MOST_LETTERS = 160  # of a name in that of an archive: file systems allow 255 bytes

LINES = ("solid", "dashed", "dashdot")
"""Kinds of line; a dotted one is the damper's energy."""


@dataclass(frozen=True)
class Curve:
    """One curve of a panel: what is computed, and how it looks.

    Arguments:
        scan: along one parameter.
        label: in the legend; empty for a label made from `settings` or from the system.
        settings: what panel and curve set, beyond what the whole page shares.
        colour: as `#rrggbb`; `line`: of `LINES`.
        base: whether it is the one to look at, drawn stronger.
        shade: whether the panel shows where this one has impacts.
    """

    scan: Scan
    label: str = ""
    settings: Mapping[str, float] = field(default_factory=dict)
    colour: str = "#000000"
    line: str = "solid"
    base: bool = False
    shade: bool = False

    @property
    def name(self) -> str:
        """The system, and whatever of it is not as in the catalogue: `tmd_k2=2083_c2=112`."""
        return curve_name(self.scan)


@dataclass(frozen=True)
class Panel:
    """One frame of a page and the curves in it; `base` marks the frame of the tuning."""

    curves: tuple[Curve, ...]
    title: str = ""
    settings: Mapping[str, float] = field(default_factory=dict)
    base: bool = False


@dataclass(frozen=True)
class FigureRequest:
    """What a picture needs.

    Arguments:
        path: of the TOML file.
        kind: `curves`, `scan` or `portrait`.
        title: of the page.
        panels: for `scan` one, with one curve; for `portrait` none.
        columns: panels side by side.
        damper_energy: whether E2max is drawn beside E1max, dotted.
    """

    path: Path
    kind: str
    title: str
    panels: tuple[Panel, ...] = ()
    columns: int = 1
    damper_energy: bool = False

    @property
    def name(self) -> str:
        """The name of picture and file, `figure2a`."""
        return self.path.stem

    @property
    def curves(self) -> tuple[Curve, ...]:
        """All curves, panel by panel."""
        return tuple(curve for panel in self.panels for curve in panel.curves)

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


def curve_name(scan: Scan) -> str:
    """Return the name of a scan's system, and what of it is not as in the catalogue."""
    system = scan.system
    known = catalogue()[system.name].parameters if system.name in catalogue() else {}
    changed = {key: value for key, value in system.parameters.items() if known.get(key) != value}
    return "_".join([system.name, *(f"{key}={value:g}" for key, value in changed.items())])
