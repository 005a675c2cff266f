"""Orbits of an oscillator with a rigid stop in closed form: `data/reference/rigid.json`."""

import json
import math

import numpy as np
from scipy.linalg import expm
from support import REPO

from nlds_vines.model.linear_response import flow_matrix
from nlds_vines.model.system import System

RIGID = json.loads((REPO / "data" / "reference" / "rigid.json").read_text())
CASES = RIGID["cases"]


def oscillator(case, P, law="restitution", **constants):
    """Return the oscillator of a case under a force, with its stop or one of another law."""
    numbers = {"m": 1.0, "k": RIGID["k"], "c": RIGID["c"], "C": RIGID["d"], "omega": case["omega"]}
    return System("oscillator", {**numbers, "P": P, **(constants or {"e": case["e"]})}, law=law)


def start_of(case, orbit):
    """Return (x, v) at the end of the period of an orbit's impact, by the solution after it."""
    phase, system = orbit["phase"], oscillator(case, orbit["A"])
    behind = np.array([RIGID["d"], -case["e"] * orbit["speed"], 0, 0, 0, 0])
    behind[4:] = math.cos(phase), math.sin(phase)
    return (expm(flow_matrix(system) * ((2 * np.pi - phase) / case["omega"])) @ behind)[:2]
