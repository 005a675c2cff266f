"""The claims of the paper in our own words, each with the rule by which archives are judged.

In reading order:

    measured            the data of archives, and orbits in full
    claim               a claim, and the verdicts there are
    contact_constants   section 2: the contact stiffness, which the paper does not fix
    parameter_sets      section 3.1: six parameter sets
    three_dampers       section 3.2: the comparison with TMD and SSbl NES
    retention           section 4.1: the energy that is kept when the stiffness changes
    damping_and_force   sections 4.2, 4.3: when the damping or the force changes
    damper_designs      section 2: designs of the damper, the surface on which it strikes
    free_movement       section 2: the design of Figure 1c, which the paper leaves open
    published_optima    sections 2 and 3: whether the printed dampers are optima
    dynamics            section 5: the regimes of the SSul NES at different frequencies
    single_orbits       section 5: the orbits of Figures 9 and 10
    facts               closed forms beside the results of simulations
"""

from paper.claims.claim import Claim, Finding, Verdict, judge
from paper.claims.contact_constants import CONTACT
from paper.claims.damper_designs import DESIGNS
from paper.claims.damping_and_force import DAMPING_AND_FORCE
from paper.claims.dynamics import DYNAMICS
from paper.claims.facts import FACTS
from paper.claims.measured import Data, Evidence, Missing, Motion, archived
from paper.claims.parameter_sets import PARAMETER_SETS
from paper.claims.published_optima import OPTIMA
from paper.claims.retention import STIFFNESS_CHANGED
from paper.claims.single_orbits import SINGLE_ORBITS
from paper.claims.three_dampers import COMPARISON

CLAIMS = (
    *CONTACT,
    *DESIGNS,
    *PARAMETER_SETS,
    *OPTIMA,
    *COMPARISON,
    *STIFFNESS_CHANGED,
    *DAMPING_AND_FORCE,
    *DYNAMICS,
    *SINGLE_ORBITS,
)
"""The paper's claims in the order of its sections."""

__all__ = [
    "CLAIMS",
    "FACTS",
    "Claim",
    "Data",
    "Evidence",
    "Finding",
    "Missing",
    "Motion",
    "Verdict",
    "archived",
    "judge",
]
