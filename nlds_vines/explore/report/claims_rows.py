"""The claims of the paper and their verdicts, from the archives in a folder of `reproduce`."""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple

from nlds_vines.errors import RequestError
from nlds_vines.reproduce.claims import CLAIMS, archived, judge
from nlds_vines.reproduce.request_file import packaged_figures

ARCHIVES = "archives"
"""The folder of archives in a folder of `reproduce`."""


class ClaimRow(NamedTuple):
    """A claim: where it stands, what it says, what comes out, and the verdict."""

    where: str
    claim: str
    found: str
    verdict: str


def claims_rows(folder: Path) -> list[ClaimRow]:
    """Return all claims with their verdicts; nothing is computed but a few orbits.

    Raises `RequestError` where the folder is none that `reproduce` has made.
    """
    archives = archives_of(folder)
    from nlds_vines.reproduce.motion import motions_of

    evidence = archived(packaged_figures(), archives, motions_of)
    rows = []
    for claim in CLAIMS:
        finding = judge(claim, evidence)
        rows.append(ClaimRow(claim.where, claim.statement, finding.text, str(finding.verdict)))
    return rows


def archives_of(folder: Path) -> Path:
    """Return the folder of the archives; `RequestError` where there is none."""
    archives = folder / ARCHIVES
    if not archives.is_dir():
        raise RequestError(f"{folder} holds no folder {ARCHIVES!r}: nlds-vines reproduce makes one")
    return archives


def main_archive(folder: Path) -> Path:
    """Return the archive of Figure 8 in a folder of `reproduce`, or else the first there is."""
    found = sorted(archives_of(folder).glob("*.h5"))
    if not found:
        raise RequestError(f"{folder / ARCHIVES} holds no archive (.h5)")
    return next((path for path in found if path.name.startswith("figure8")), found[0])
