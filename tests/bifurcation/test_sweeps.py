"""Sweeps over what moves the damper's rest: each cell continues the orbit of the one before."""

import numpy as np
import pytest

from nlds_vines.bifurcation.block_files import Block
from nlds_vines.bifurcation.compute import Computer
from nlds_vines.bifurcation.request_file import load_scan
from nlds_vines.orbits.simulation import simulate

TRANSIENT, PERIODS = 3, 2


@pytest.mark.kernels
@pytest.mark.parametrize("method", ["exact", "rk4"])
@pytest.mark.parametrize("policy", ["up", "down"])
@pytest.mark.parametrize(
    ("system", "name", "values"),
    [
        ("ssul-set6", "C", [0.05, 0.056, 0.0623]),
        ("ssul-set6", "V", [0.1, 0.25, 0.3]),
        ("ssbl", "D", [0.05, 0.06, 0.08]),
        ("ssbl", "C", [0.3, 0.33, 0.36]),
    ],
)
def test_a_sweep_goes_on_as_simulate_does_from_the_last_state(system, name, values, policy, method):
    """The displacement x2 is carried over. Notices: a sweep that carries r without the rest."""
    scan = load_scan(
        {
            "system": system,
            "vary": {name: {"values": values}},
            "start": {"policy": policy},
            "sampling": {"transient": TRANSIENT, "periods": PERIODS, "method": method},
            "record": {"want": ["section", "impacts"]},
        }
    )
    found = Computer(scan).block(Block(0, ((0, scan.lanes),)))
    state = None
    for value in values if policy == "up" else values[::-1]:
        i = values.index(value)
        system_now = scan.system.with_(**{name: value})
        orbit = simulate(
            system_now, PERIODS, start=state, transient=TRANSIENT, method=method,
            record=("section", "impacts"),
        )  # fmt: skip
        scale = np.abs(orbit.section).max()
        np.testing.assert_allclose(found["section"][i, 0], orbit.section, rtol=0, atol=1e-9 * scale)
        state = orbit.section[-1]
