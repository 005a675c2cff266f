"""What the paper says, in words of ours, and a check of each against archives."""

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
