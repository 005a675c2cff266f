"""Derivatives of hosts' orbits: beside differences, determinants, and kernels of one damper."""

from dataclasses import replace

import numpy as np
import pytest
from host_flows import HostMap
from test_hosts import as_host, random_system

import nlds_vines as nv

pytestmark = pytest.mark.kernels

FRAME = nv.shear_frame([1000.0, 800.0], [8e4, 6e4], ratio=0.02)
LAWS = {
    "hertz": {"K": 1e7},
    "power 1": {"law": "power", "K": 3e5, "exponent": 1.0},
    "power 1.25": {"law": "power", "K": 3e5, "exponent": 1.25},
    "power 1.7": {"law": "power", "K": 3e6, "exponent": 1.7},
    "hunt-crossley": {"K": 1e7, "hunt_crossley": 5.0},
    "linear": {"law": "linear", "kc": 1e6, "cc": 500.0},
    "kelvin-voigt": {"law": "kelvin-voigt", "kc": 1e6, "cc": 500.0},
    "restitution": {"law": "restitution", "e": 0.6},
    "held": {"law": "restitution", "e": 0.0},
}
CONSERVE = ("hertz", "power 1", "power 1.25", "power 1.7")


def frame_with(one, two, omega=4.0, P=900.0):
    first = nv.Damper(
        "one",
        "roof",
        m=60.0,
        k=300.0,
        c=40.0,
        walls=[nv.Wall(0.03, **one), nv.Wall(0.05, "-", **one)],
    )
    second = nv.Damper("two", "floor1", m=30.0, k=150.0, c=20.0, walls=[nv.Wall(0.01, **two)])
    return nv.System.from_host(FRAME, [first, second], force={"roof": P}, omega=omega)


def error_of(flow, y, periods):
    """Return the orbit, and the largest error of its derivative beside differences."""
    orbit = flow(y, periods)
    scales, off, most = flow.scales(orbit.sections), 0.0, 0.0
    for c in range(flow.size):
        direction = scales[c] * np.eye(flow.size)[c]
        slope = flow.difference(y, periods, direction) / scales
        off = max(off, np.abs(orbit.matrix @ direction / scales - slope).max())
        most = max(most, np.abs(slope).max())
    return orbit, off / most


@pytest.mark.parametrize("law", LAWS)
def test_a_derivative_is_the_limit_of_differences(law):
    flow = HostMap(frame_with(LAWS[law], LAWS[law]))
    y = flow(np.zeros(flow.size), 4, False).sections[-1]
    orbit, error = error_of(flow, y, 3)
    assert min(orbit.counts) > 2
    # where a force has no power series the first step of a contact has no stiffness
    assert error < (1e-6 if law == "power 1.7" else 1e-8)
    alone = flow(y, 3, False)
    assert np.array_equal(alone.sections, orbit.sections)
    assert np.array_equal(alone.state, orbit.state)
    sign, volume = np.linalg.slogdet(orbit.matrix)
    lost = volume - orbit.trace * 3 * flow.orbits.body.period
    assert sign > 0
    assert abs(lost) < 1e-9 if law in CONSERVE else lost < -1.0


@pytest.mark.parametrize(
    ("one", "two"),
    [
        ("restitution", "hertz"),
        ("held", "kelvin-voigt"),
        ("restitution", "linear"),
        ("held", "held"),
    ],
)
def test_walls_of_several_laws_are_closed_at_once(one, two):
    soft = {name: value / 10 for name, value in LAWS[two].items() if name in ("K", "kc")}
    flow = HostMap(frame_with(LAWS[one], {**LAWS[two], **soft}, 1.3, 3000.0))
    y = flow(np.zeros(flow.size), 4, False).sections[-1]
    orbit, error = error_of(flow, y, 2)
    assert error < 1e-7
    assert sum(orbit.counts) > 1
    # closed at once: contacts last for a part of a period, and rigid walls hold
    assert np.abs(np.linalg.eigvals(orbit.matrix)).min() < 1e-3 * np.abs(orbit.matrix).max()


def test_an_orbit_on_a_wall_that_holds_varies_along_it():
    """A displacement off the wall falls back to it."""
    hit = nv.Wall(0.01, law="restitution", e=0.0)
    dampers = [
        nv.Damper("g", ("roof", "ground"), walls=[nv.Wall(0.02, law="restitution", e=0.4)]),
        nv.Damper("t", ("floor1", "roof"), walls=[hit]),
        nv.Damper("m", "roof", m=60.0, k=100.0, c=10.0, walls=[nv.Wall(0.02, K=1e6)]),
    ]
    flow = HostMap(nv.System.from_host(FRAME, dampers, force={"roof": 2000.0}, omega=2.5))
    begun = flow(np.zeros(flow.size), 3)
    y, walls, n = begun.sections[-1], flow.orbits.walls.number, flow.size // 2
    assert list(begun.state[flow.size + walls :] != 0) == [False, True, False]
    orbit = flow(y, 1)
    rows = flow.orbits.body.rows.reshape(-1, n)
    row = rows[flow.orbits.walls.links[1]]
    assert row @ begun.matrix[:n] == pytest.approx(0, abs=1e-12)
    off = np.concatenate([row / (row @ row), np.zeros(n)])
    scales = flow.scales(orbit.sections)
    assert np.abs(orbit.matrix @ off).max() < 1e-12
    for c in range(flow.size):
        direction = scales * np.eye(flow.size)[c]
        for part in (direction[:n], direction[n:]):  # along the wall
            part -= row * (row @ part) / (row @ row)
        slope = flow.difference(y, 1, direction)
        assert orbit.matrix @ direction / scales == pytest.approx(slope / scales, abs=1e-7)


@pytest.mark.parametrize(
    ("name", "changes"),
    [
        ("ssul-set6", {"omega": 6.28}),
        ("ssul-set6", {"omega": 6.28, "law": "restitution", "e": 0.7}),
        ("ssul-set6", {"omega": 1.28, "law": "restitution", "e": 0.0, "P": 3000.0}),
    ],
)
def test_multipliers_are_those_of_a_system_of_one_damper(name, changes):
    system = nv.load_system(name, **changes)
    regime = nv.classify(system, quiet=True)
    flow = HostMap(as_host(system))
    point = regime.point.copy()
    point[2] -= system.rest
    orbit = flow(flow.orbits.start(point), regime.period)
    assert sum(orbit.counts) == regime.impacts
    assert np.abs(orbit.sections[-1] - flow.orbits.start(point)).max() < 1e-9
    values = np.linalg.eigvals(orbit.matrix)
    values = values[np.argsort(-np.abs(values), kind="stable")]
    assert np.abs(values) == pytest.approx(np.abs(regime.multipliers), rel=1e-6, abs=1e-9)


def test_volumes_shrink_by_the_trace_where_contacts_conserve_energy():
    touched = 0
    for seed in range(4):
        system = random_system(seed)
        dampers = [
            replace(damper, walls=[nv.Wall(wall.gap, wall.side, K=1e7) for wall in damper.walls])
            for damper in system.dampers
        ]
        load = {"force": dict(system.force), "omega": system.omega}
        flow = HostMap(nv.System.from_host(system.host, dampers, **load))
        orbit = flow(np.zeros(flow.size), 3)
        scales = flow.scales(orbit.sections)
        _, volume = np.linalg.slogdet(orbit.matrix * scales / scales[:, None])
        assert volume == pytest.approx(orbit.trace * 3 * flow.orbits.body.period, abs=1e-7), seed
        touched += sum(orbit.counts)
    assert touched > 10
