"""The scan that an archive holds, as a request again."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from nlds_vines.archives.toml import parse_toml
from nlds_vines.archives.view import ArchiveView
from nlds_vines.bifurcation.request import Scan
from nlds_vines.bifurcation.request_file import load_scan
from nlds_vines.errors import RequestError, at, shown
from nlds_vines.model.layers import request_hash
from nlds_vines.model.parameters import PHASE
from nlds_vines.orbits.settings import FINENESS
from nlds_vines.runs.manifest import refuse_unless_scan

UNTIL_TOLERANCE = {"nodes": 12, "contact_steps": 28.0}
"""Settings of `exact` in archives that were made before there was a tolerance."""


def scan_in(path: Path) -> Scan:
    """Return the scan of an archive; `RequestError` if there is none, and as `scan_of`."""
    if not path.is_file():
        raise RequestError(f"{shown(str(path))}: there is no such file")
    from nlds_vines.archives import archive

    with archive.read(path) as view:
        return scan_of(view)


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


def begins_at_sections(view: ArchiveView) -> bool:
    """Tell whether all orbits of a scan begin at phase zero, as points of attractors lie."""
    start = parse_toml(view.text("scan"), "the attribute scan").get("start", {})
    return PHASE not in view.axes and not start.get(PHASE)
