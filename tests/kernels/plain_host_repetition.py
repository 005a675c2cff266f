"""Periods of hosts that are copied are, to the last bit, those that would have been computed.

(Run by `contract/test_plain.py`: only plain Python can switch the repetition off.)
"""

import numpy as np
import pytest

import nlds_vines as nv
from nlds_vines.engine.host_orbits import HostOrbits
from nlds_vines.kernels.hosts import host_orbit, host_repetition
from nlds_vines.kernels.scene.scene import Span

SETTLED, PERIODS = 40, 50


def damped(walls):
    """Return one strongly damped structure, whose transients are short, with a damper."""
    host = nv.Host(M=[[1.0]], K=[[1.0]], ratio=0.5, dofs=["x"])
    cell = nv.Damper("cell", "x", m=0.1, k=0.05, c=0.15, walls=walls)
    return nv.System.from_host(host, [cell], force={"x": 1.0}, omega=0.9)


CASES = {
    "short impacts": damped([nv.Wall(1.5, K=100.0)]),
    "rigid walls": damped([nv.Wall(1.2, s, law="restitution", e=0.3) for s in "+-"]),
    "contacts across sections": damped(
        [nv.Wall(0.3, side, law="linear", kc=0.2, cc=0.1) for side in "+-"]
    ),
    "held by a wall": damped([nv.Wall(-0.5, law="restitution", e=0.2)]),
}


@pytest.fixture
def cycles(monkeypatch):
    """Return a list that takes the length of each repetition."""
    noted, next_period = [], host_orbit.next_period

    def noting(repetition, host, watch, limits, p, state):
        following = next_period(repetition, host, watch, limits, p, state)
        noted.extend([int(n) for n in repetition.periods[host_repetition.CYCLE :][:1] if n > 0])
        return following

    monkeypatch.setattr(host_orbit, "next_period", noting)
    return noted


def records_of(system, first, stops, noted, rows=("x", "cell")):
    """Return all that is recorded of an orbit, as bytes."""
    orbits = HostOrbits(system)
    records = orbits.records(True, rows)
    state = orbits.start(None)
    span = Span(first, PERIODS, stops)
    code, section, impacts = orbits.follow(state, span, records, noted, True)
    rows = impacts.data.reshape(-1, host_repetition.ROW_OF_IMPACT)[: impacts.filled[0]]
    arrays = (
        state, section, rows, impacts.counts, impacts.hardest, records.peaks, records.squares
    )  # fmt: skip
    return code, *(array.tobytes() for array in arrays)


def repeat_nothing(monkeypatch):
    def never(repetition, host, watch, limits, p, state):
        return p, limits[0]

    monkeypatch.setattr(host_orbit, "next_period", never)


@pytest.mark.parametrize("case", CASES)
@pytest.mark.parametrize(("first", "stops", "noted"), [(SETTLED, 1, 9), (0, 2, 0)])
def test_all_records_have_the_same_bits(case, first, stops, noted, cycles, monkeypatch):
    copied = records_of(CASES[case], first, stops, noted)
    assert cycles
    repeat_nothing(monkeypatch)
    assert copied == records_of(CASES[case], first, stops, noted)


def test_energies_alone_have_the_same_bits(cycles, monkeypatch):
    """They are searched for by kernels of their own."""
    system = CASES["short impacts"]
    copied = records_of(system, SETTLED, 1, 0, ())
    assert cycles
    repeat_nothing(monkeypatch)
    assert copied == records_of(system, SETTLED, 1, 0, ())


def test_periods_before_records_are_left_out(cycles, monkeypatch):
    """A long transient costs nothing once the orbit repeats."""
    system = CASES["short impacts"]
    periods, run_part = [], host_orbit.run_part

    def counted(*arguments):
        periods.append(0)
        return run_part(*arguments)

    monkeypatch.setattr(host_orbit, "run_part", counted)
    records_of(system, 4000, 1, 16)
    assert len(cycles) == 2  # of the transient, and of the periods that are recorded
    assert len(periods) < 200


def test_an_unfinished_row_is_that_of_the_last_cycle(cycles):
    """A contact at a section has a row without a release; its earlier copies are complete."""
    system = CASES["contacts across sections"]
    orbits = HostOrbits(system)
    _, _, impacts = orbits.follow(orbits.start(None), Span(SETTLED, PERIODS, 1))
    rows = impacts.data.reshape(-1, host_repetition.ROW_OF_IMPACT)[: impacts.filled[0]]
    assert cycles
    assert np.flatnonzero(np.isnan(rows[:, host_repetition.OF_RELEASE])).tolist() == [len(rows) - 1]
    lengths = rows[:-1, host_repetition.OF_RELEASE] - rows[:-1, host_repetition.OF_TOUCH]
    np.testing.assert_allclose(lengths[2:], lengths[:-2], rtol=1e-9)
    np.testing.assert_allclose(
        np.diff(rows[::2, host_repetition.OF_TOUCH]), system.period, rtol=1e-9
    )
