"""A thousand calls from Python with values that no one means."""

import random

import numpy as np
import pytest
from contract.made_up import MAP, make_scan, write
from fuzz.rule import CASES, VALUES, broken_by, call, short

import nlds_vines as nv

pytestmark = pytest.mark.long

ODD = (
    *VALUES, b"bytes", (), (1, 2), {1: 2}, set(), range(3), object(), len, int, 1j, np.float64(1),
    np.zeros(3), np.zeros((2, 2)), np.array(["a"]), "ssul-set6", "m.h5", "/", ("a", "b", "c"),
)  # fmt: skip

CALLS = {
    "load_system": ["name_or_path", "P", "K", "omega", "law", "e"],
    "load_scan": ["source", "changes", "changes_from"],
    "load_tuning": ["source", "changes", "changes_from"],
    "load_continuation": ["source", "changes", "changes_from"],
    "read": ["path"],
    "plot": ["archive", "show"], "ensemble_of": ["source"], "basin_measures": ["archive"],
    "orbit_of": ["archive", "omega", "P", "start"], "spectrum": ["orbit", "signal"],
    "System": ["kind", "parameters"], "Scan": ["title", "system", "axes", "want"],
}  # fmt: skip
"""What computes nothing, or nothing with a value that is not allowed, and its arguments."""

USUAL = nv.load_scan()
SOUND = {
    "System": {"parameters": dict(USUAL.system.parameters)},
    "Scan": {name: getattr(USUAL, name) for name in ("system", "axes", "want")},
}
"""What must be given."""


def test_no_call_breaks_the_rule(here):
    write(here / "m.h5", make_scan(("energy", "regime"), vary=MAP))
    rng, wrong = random.Random(4), []
    for number in range(CASES):
        name = rng.choice(sorted(CALLS))
        first, *others = CALLS[name]
        keywords = dict(SOUND.get(name, {}))
        keywords |= {other: rng.choice(ODD) for other in others if rng.random() < 0.4}
        given = rng.choice(ODD)
        if found := broken_by(call(getattr(nv, name), given, **keywords), here):
            wrong.append(
                f"case {number}: {name}({first}={short(given)}, {short(keywords)}): {found}"
            )
    assert not wrong, "\n".join(wrong)
