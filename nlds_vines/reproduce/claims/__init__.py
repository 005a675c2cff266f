"""The claims of the paper, in our own words, each with a check against archives.

In reading order:

    claim               what a claim is, the data that it is checked against, its verdict
    contact_constants   Section 2
    dampers             Section 3
    retention           Section 4
    dynamics            Section 5
    facts               this program against closed forms
"""

from nlds_vines.reproduce.claims.claim import (
    Claim,
    Data,
    Evidence,
    Finding,
    Missing,
    Verdict,
    archived,
    judge,
)
from nlds_vines.reproduce.claims.contact_constants import CONTACT
from nlds_vines.reproduce.claims.dampers import COMPARISON, DAMPERS
from nlds_vines.reproduce.claims.dynamics import DYNAMICS
from nlds_vines.reproduce.claims.facts import FACTS
from nlds_vines.reproduce.claims.retention import RETENTION

CLAIMS = (*CONTACT, *DAMPERS, *COMPARISON, *RETENTION, *DYNAMICS)
"""The paper's claims in the order of its sections."""

__all__ = [
    "CLAIMS",
    "FACTS",
    "Claim",
    "Data",
    "Evidence",
    "Finding",
    "Missing",
    "Verdict",
    "archived",
    "judge",
]
