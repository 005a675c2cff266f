"""The archive of a scan: as Python has it, a path that can be read and drawn, and as a request."""

from __future__ import annotations

import os
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from nlds_vines.archives.archive_path import ArchivePath
from nlds_vines.archives.toml import parse_toml
from nlds_vines.bifurcation.request import Scan
from nlds_vines.bifurcation.request_file import load_scan
from nlds_vines.errors import RequestError, at, shown
from nlds_vines.model.request_layers import request_hash
from nlds_vines.orbits.solver_settings import FINENESS
from nlds_vines.runs.manifest import refuse_unless_scan

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from nlds_vines.archives.view import ArchiveView

UNTIL_TOLERANCE = {"nodes": 12, "contact_steps": 28.0}
"""Settings of `exact` in archives that were made before there was a tolerance."""


class ScanArchive(ArchivePath):
    """The path of a scan's archive; wherever a path may stand, it may stand.

    Attributes:
        picture: the path of the picture that was drawn with it; None for none.
    """

    picture: Path | None = None

    @classmethod
    def of(
        cls, path: str | os.PathLike[str], picture: str | os.PathLike[str] | None = None
    ) -> ScanArchive:
        """Return the archive at a path, with the path of its picture."""
        found = super().of(path)
        found.picture = None if picture is None else Path(picture)
        return found

    @property
    def request(self) -> Scan:
        """The scan, with which the same numbers are computed again."""
        if not self.is_file():
            raise RequestError(f"{shown(str(self))}: there is no such file")
        with self.read() as view:
            return scan_of(view)

    def plot(self, show: str | None = None, ax: Axes | None = None) -> Figure:
        """Return its picture as a matplotlib figure, as `nlds_vines.plot` does."""
        from nlds_vines.bifurcation.picture.drawing import PICTURE

        return PICTURE.of(self, show, ax)


def scan_of(view: ArchiveView) -> Scan:
    """Return the scan of an open archive.

    Raises `RequestError` if it holds no scan, or if its scan means something else by now.
    """
    refuse_unless_scan(f"{view.path} holds", view.content)
    text, digest = view.text("scan"), view.text("scan_hash")
    with at(f"{view.path}: its scan"):
        document = parse_toml(text, "the attribute scan")
        scan, known = _meant_by(document)
    if known != digest:
        raise RequestError(
            f"{view.path}: its scan is damaged, or means something else to this version; "
            f"it was made by {view.attrs.get('source', 'an unknown version')}"
        )
    return scan


def _meant_by(document: Mapping[str, Any]) -> tuple[Scan, str]:
    """Return the scan that an archive's document means, and the hash that the archive should have.

    A document of `exact` that knows no tolerance means `UNTIL_TOLERANCE`, and was hashed without.
    """
    sampling = document.get("sampling", {})
    if sampling.get("method") != "exact" or "tolerance" in sampling:
        scan = load_scan(document)
        return scan, scan.hash
    scan = load_scan({**document, "sampling": {**sampling, **UNTIL_TOLERANCE}})
    found = scan.document()
    known = {name: value for name, value in found["sampling"].items() if name not in FINENESS}
    return scan, request_hash({**found, "sampling": known})
