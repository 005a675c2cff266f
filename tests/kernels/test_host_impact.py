"""Short impacts of hosts, solved at once, beside the same impacts in steps."""

import numpy as np
import pytest
from host_flows import HostMap
from test_hosts import random_system

import nlds_vines as nv

pytestmark = pytest.mark.kernels


class Stepped(HostMap):
    """A flow that steps each impact, as no rest of a series is small enough."""

    def __init__(self, system):
        super().__init__(system, 1e-13)
        contacts = self.orbits.contacts()
        arc = contacts.arc._replace(settled=0.0)
        self.orbits.contacts = lambda: contacts._replace(arc=arc)


def under_hertz(seed):
    """Return a random host all of whose walls obey Hertz' law, and their stiffness."""
    system, K = random_system(seed), 10 ** np.random.default_rng([seed, 2]).uniform(6, 11)
    dampers = [
        nv.Damper(
            one.name, one.attached_to, m=one.m, k=one.k, c=one.c,
            walls=[nv.Wall(wall.gap, wall.side, K=K) for wall in one.walls],
        )
        for one in system.dampers
    ]  # fmt: skip
    return nv.System.from_host(system.host, dampers, force=system.force, omega=system.omega)


def beam():
    """Return a beam whose highest mode is 57 times as fast as the first, and hardly moves."""
    host = nv.beam(1.0, 65.6, 1.18, ratio=0.02).reduced(5, statics=["w20"])
    ball = nv.Damper("ball", "w20", m=0.06, k=40.0, c=0.3, walls=[nv.Wall(0.01, K=2e9)])
    return nv.System.from_host(host, [ball], force={"w20": 1.0}, omega=26.0)


SEEDS = [range(6), pytest.param(range(6, 200), marks=pytest.mark.long)]


@pytest.mark.parametrize("seeds", SEEDS)
def test_errors_are_below_the_tolerance(seeds):
    """Notices: a power, a term of the memory or a moment left out; variations of another impact."""
    solved = 0
    for system in (*map(under_hertz, seeds), beam()):
        exact = Stepped(system)
        y = exact(np.zeros(exact.size), 3, False).sections[-1]
        true = exact(y, 1)
        scales = exact.scales(np.stack([y, *true.sections]))
        matrix = true.matrix * scales / scales[:, None]
        gain = max(np.abs(matrix).max(), 1.0) * max(true.counts.sum(), 1)
        for tolerance in (1e-6, 1e-8, 1e-10, 1e-12):
            orbit = HostMap(system, tolerance)(y, 1, tolerance == 1e-12)
            error = np.abs((orbit.sections - true.sections) / scales).max()
            assert error < (tolerance + 2e-14) * gain
            solved += error > 0
        assert np.abs(orbit.matrix * scales / scales[:, None] - matrix).max() < 1e-9 * gain
    assert solved > len(seeds)


def test_records_leave_an_orbit_as_it_is():
    system = beam()
    alone = nv.simulate(system, 5, quiet=True)
    watched = nv.simulate(system, 5, record=["section", "impacts", "energy"], quiet=True)
    assert np.array_equal(alone.section, watched.section)
    assert np.array_equal(alone.impacts, watched.impacts)
    assert len(alone.impacts) > 3
