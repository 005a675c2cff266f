"""Sweeps over what moves the walls and the rest offset, link by link against `simulate`.

The next cell begins with the displacements that the one before ended with, wherever the spring of
the new cell rests and its walls stand. (Run by `contract/test_plain.py`.)
"""

import numpy as np
import pytest

import nlds_vines as nv
from nlds_vines.kernels.scene.codes import OK, TOO_STIFF
from nlds_vines.kernels.scene.scene import LaneBuffers, Span
from nlds_vines.orbits.batch import run
from nlds_vines.orbits.kernel_inputs import parts_of
from scans import computed, scan_of

TRANSIENT, PERIODS = 2, 3
STEPS = 64  # of a period by rk4: the sweep and the single orbits err alike
RECORD = ("section", "impacts", "energy", "clearance")
LINKS = [(50.0, 0.1), (1e12, 0.2), (60.0, 0.3)]  # dashpot and place of the wall; one is too stiff
SWEEPS = {
    # what varies, and its values: the damper is pressed onto another wall, or lies beyond it
    "ssbl, D": ("ssbl", "D", [0.01, 0.03, 0.05, 0.06]),
    "ssbl, C": ("ssbl", "C", [0.01, 0.03, 0.05, 0.06]),
    "ssul, C": ("ssul-set6", "C", [-0.005, 0.0, 0.02, 0.05]),
    "ssul, V": ("ssul-set6", "V", [0.05, 0.1, 0.15, 0.3]),
    "a linear damper, k2": ("tmd", "k2", [300.0, 600.0, 900.0, 1200.0]),
}


@pytest.mark.parametrize(
    ("policy", "method"), [("up", "exact"), ("down", "exact"), ("down", "rk4")]
)
@pytest.mark.parametrize("case", SWEEPS)
def test_every_link_begins_where_the_one_before_ended(case, policy, method):
    name, parameter, values = SWEEPS[case]
    walls = bool(nv.load_system(name).scene.walls)
    record = RECORD if walls else ("section", "energy")
    sampling = {"transient": TRANSIENT, "periods": PERIODS, "method": method}
    if method == "rk4":
        sampling["period_steps"] = STEPS
    arrays = computed(scan_of(name, record, {parameter: values}, policy, **sampling))
    assert (arrays["status"] == OK).all()
    state, order = None, range(len(values))
    for i in order if policy == "up" else reversed(order):
        system = nv.load_system(name, **{parameter: values[i]})
        orbit = nv.simulate(system, start=state, record=record, **sampling)
        state = orbit.state
        np.testing.assert_allclose(arrays["section"][i, 0], orbit.section, rtol=0, atol=1e-10)
        assert arrays["E1max"][i, 0] == pytest.approx(orbit.E1max, rel=1e-8)
        assert arrays["E2max"][i, 0] == pytest.approx(orbit.E2max, rel=1e-8)
        if walls:
            assert arrays["impact_rate"][i, 0] * PERIODS == len(orbit.impacts)
            assert arrays["clearance"][i, 0] == pytest.approx(orbit.clearance, abs=1e-10)


def test_after_a_link_that_failed_the_next_begins_at_rest():
    """At its own rest, wherever that of the link before was, and whatever moved before that."""
    systems = [nv.load_system("ssul-set6", c2=c2, V=V) for c2, V in LINKS]
    cells = np.array([[system.cells() for system in systems]])
    section, status = np.zeros((1, 3, PERIODS, 4)), np.array([[OK, TOO_STIFF, OK]])
    buffers = LaneBuffers(section=section)
    parts, span = parts_of("exact", systems[0].scene), Span(TRANSIENT, PERIODS, 1)
    np.testing.assert_array_equal(run(parts, cells, np.zeros((1, 4)), span, buffers), status)
    for i in (0, 2):
        alone = nv.simulate(systems[i], PERIODS, transient=TRANSIENT)
        np.testing.assert_allclose(section[0, i], alone.section, rtol=0, atol=1e-10)


def test_impacts_are_counted_by_wall():
    vary = {"omega": [6.0, 6.28]}
    arrays = computed(scan_of("ssbl", ["impacts"], vary, transient=60, periods=9))
    for i, omega in enumerate((6.0, 6.28)):
        system = nv.load_system("ssbl", omega=omega)
        walls = nv.simulate(system, 9, transient=60, record=("impacts",)).impacts["wall"]
        both = [np.count_nonzero(walls == name) for name in ("structure", "obstacle")]
        assert arrays["impact_rate"][i, 0] * 9 == pytest.approx(sum(both))
        assert min(both) > 0
