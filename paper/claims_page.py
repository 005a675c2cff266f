"""The diagram of Figure 8 as a page, with the claims of the paper and their verdicts."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from nlds_vines.archives.files import write_text
from nlds_vines.explore.map_data import stored
from nlds_vines.explore.report_page import Table, report_page
from paper.claims import CLAIMS, archived, judge
from paper.motion import motions_of
from paper.request import FigureRequest


def write_page(
    path: Path, archives: Path, requests: Mapping[str, FigureRequest], shown: str
) -> None:
    """Write the page: what is `shown` is the archive of that name in the folder `archives`.

    Arguments: the `path` of the page; the paper's `requests` by short name.

    Raises `RequestError` where an archive cannot be read or the page cannot be written.
    """
    evidence = archived(requests, archives, motions_of)
    rows = []
    for claim in CLAIMS:
        finding = judge(claim, evidence)
        rows.append((claim.where, claim.statement, finding.text, str(finding.verdict)))
    head = "where", "claim", "what comes out", "verdict"
    table = Table("The claims of the paper", head, rows)
    write_text(path, report_page(stored(archives / shown), tables=[table]).html)
