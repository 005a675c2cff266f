"""The claims of the paper in our own words, each with the rule by which archives are judged.

In reading order:

    claim               a claim, its evidence, and the verdicts there are
    contact_constants   section 2: the contact stiffness, which the paper does not fix
    dampers             section 3: six parameter sets, and the comparison with TMD and SSbl NES
    retention           section 4: the energy that is kept when the structure or the force changes
    dynamics            section 5: the regimes of the SSul NES at different frequencies
    facts               closed forms beside the results of simulations
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
