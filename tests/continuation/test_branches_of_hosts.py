"""Branches of hosts: those of kinds, and of a frame with two dampers."""

import numpy as np
import pytest
from support import as_host

import nlds_vines as nv
from nlds_vines.continuation import run
from nlds_vines.engine.host_section_map import HostSectionMap
from nlds_vines.engine.section_map import SectionMap
from nlds_vines.engine.solver_settings import Settings

pytestmark = pytest.mark.kernels

SET_6 = nv.load_system("ssul-set6", omega=7.3)
NAMES = {"omega": "omega", "C": "u.gap", "m2": "u.m", "k2": "u.k", "c2": "u.c", "P": "force.x"}
"""The parameters of a kind, and of the same system as a host."""


def both_of(system, name, bounds, **options):
    """Return the branches of a kind and of the same system as a host."""
    pair = ((system, name), (as_host(system), NAMES[name]))
    return [nv.continue_branch(one, key, bounds, quiet=True, **options) for one, key in pair]


@pytest.mark.parametrize(
    ("law", "name", "bounds", "kinds"),
    [
        ({}, "omega", (7.3, 7.5), ["PD", "PD", "GR"]),
        ({"law": "restitution", "e": 0.7}, "omega", (7.3, 7.5), ["PD", "GR", "GR"]),
    ],
)
def test_a_kind_as_a_host_has_the_same_branches(law, name, bounds, kinds):
    kind, host = both_of(SET_6.with_(**law), name, bounds)
    one, other = kind.special_points, host.special_points
    assert one.kind.tolist() == other.kind.tolist() == kinds
    np.testing.assert_allclose(other.value, one.value, rtol=1e-11)
    assert (other.resolved & (other.defect < 1e-11)).all()
    for key in ("before", "after", "switch"):
        assert one[key].tolist() == other[key].tolist()
    assert {*other.wall[other.kind == "GR"]} <= {"u+"}
    for a, b in zip(kind.branches, host.branches, strict=True):
        assert (a.ends, a.labels[0], a.labels[-1]) == (b.ends, b.labels[0], b.labels[-1])
        assert (a.stable[0], a.stable[-1]) == (b.stable[0], b.stable[-1])
        at = 0 if b.ends[0] == "bound" else -1
        for key in ("multipliers", "E1max", "E2max", "fastest_impact", "largest_force"):
            one, other = getattr(a, key)[at], getattr(b, key)[at]
            np.testing.assert_allclose(other, one, rtol=1e-9, atol=1e-9, err_msg=key)


@pytest.mark.parametrize("law", [{}, {"law": "restitution", "e": 0.7}])
def test_derivatives_by_parameters_are_those_of_kinds(law):
    system = nv.load_system("ssul-set6", omega=6.28, **law)
    host, start = as_host(system), np.zeros(4)
    for name, key in NAMES.items():
        kind = SectionMap(system, (name,), Settings(1e-12))
        there = HostSectionMap(host, (key,), Settings(1e-12))
        value = system.parameters[name]
        place = np.append(kind.at(np.append(start, value), 8).points[-1], value)
        x1, v1, x2, v2 = kind.states_of(place[np.newaxis])[0]
        cycle = there.at(there.place_of(value, [x1, v1, x2 - system.rest, v2]), 2)
        x1, v1, r, s = kind.at(place, 2).slopes[0]
        assert sum(cycle.counts) > 0
        expected = np.array([x1, v1, x1 - r, v1 - s])
        slope = there.states_of(np.append(cycle.slopes[0], value)[np.newaxis])[0]
        assert np.abs(slope - expected).max() < 1e-7 * np.abs(expected).max(), name


@pytest.fixture(scope="module")
def frame():
    """Return a frame of three storeys with two cells on its roof, and its branch near a fold."""
    host = nv.shear_frame([1e4] * 3, [8e6] * 3, ratio=0.01)
    cells = [
        nv.Damper(
            name, "roof", m=300.0, k=2e4, c=150.0, walls=[nv.Wall(gap, s, K=3e6) for s in sides]
        )
        for name, gap, sides in (("a", 0.01, "+-"), ("b", 0.02, "+"))
    ]
    system = nv.System.from_host(host, cells, force={"roof": 1500.0}, omega=12.69)
    start = -0.0039, 0.0297, -0.0070, 0.0456, -0.0086, 0.0499, -0.0231, 0.2004, 0.0055, -0.0511
    options = {"period": 1, "step": 0.1, "quiet": True}
    return nv.continue_branch(system, "omega", (12.64, 12.7), start, **options)


def simulated_multipliers(system, state):
    """Return the eigenvalues of central differences, of order four, of an orbit of one period."""
    columns = []
    for unit in 1e-5 * np.tile([0.01, 0.1], len(state) // 2)[:, np.newaxis] * np.eye(len(state)):
        ends = [
            nv.simulate(system, 1, start=state + k * unit, tolerance=1e-12, quiet=True).state
            for k in (-2, -1, 1, 2)
        ]
        columns.append(np.dot([1.0, -8.0, 8.0, -1.0], ends) / (12.0 * unit.sum()))
    return np.linalg.eigvals(np.array(columns).T)


def test_special_points_of_a_frame_are_where_simulated_orbits_have_them(frame):
    rows = {row.kind: row for row in frame.special_points}
    assert sorted(frame.special_points.kind) == ["GR", "LP"]
    assert (frame.special_points.resolved & (frame.special_points.defect < 1e-11)).all()
    assert {rows["GR"].before, rows["GR"].after} == {"T,2 (2+0)", "T,3 (2+1)"}
    assert rows["GR"].wall == "b+"
    # the multiplier that is 1 at a fold moves by some 1e-4 where omega does by 1e-9 of itself
    fold = float(rows["LP"].value)
    mu = simulated_multipliers(frame.request.system.with_(omega=fold), rows["LP"].state)
    print(np.abs(mu - 1.0).min())
    assert np.abs(mu - 1.0).min() < 1e-5
    assert [len(frame.orbits_at(fold * (1.0 + side * 1e-9))) for side in (-1.0, 1.0)] == [0, 2]


def test_a_branch_goes_on_along_a_gap_and_is_computed_again_from_its_blocks(frame):
    (orbit,) = (one for one in frame.orbits_at(12.69) if one.stable)
    there = frame.request.system.with_(omega=12.69)
    options = {"start": orbit.state, "period": 1, "step": 0.1, "quiet": True}
    path = nv.continue_branch(there, "b.gap", (0.0195, 0.0205), **options)
    (branch,) = path.branches
    assert branch.ends == ("bound", "bound")
    assert branch.E2max.shape == (len(branch), 2)
    for i in (0, -1):
        system = there.with_(**{"b.gap": branch.parameter[i]})
        end = nv.simulate(system, 1, start=branch.states[i], tolerance=1e-12, quiet=True).state
        assert np.abs(end - branch.states[i]).max() < 1e-11
    blocks = []

    def kept(make):
        blocks.append(make())
        return blocks[-1]

    tables = run.compute(path.request, kept)
    for again in (tables, run.compute(path.request, lambda make: blocks.pop(0))):
        for name, values in path.tables.items():
            np.testing.assert_array_equal(again[name], values, err_msg=name)


def test_a_host_without_walls_has_branches_that_scale_with_its_force(tmp_path):
    host = nv.shear_frame([1e4] * 2, [8e6] * 2, ratio=0.05)
    damper = nv.Damper("tmd", "roof", m=900.0, k=1e5, c=2e3)
    system = nv.System.from_host(host, [damper], base={"acceleration": 0.1}, omega=12.0)
    options = {"step": 0.1, "quiet": True, "to": tmp_path / "tmd.h5"}
    (branch,) = nv.continue_branch(system, "ground.acceleration", (0.1, 0.2), **options).branches
    assert {*branch.labels} == {"T,0"}
    assert branch.stable.all()
    assert branch.impacts.shape == (len(branch), 0)
    np.testing.assert_allclose(
        branch.E1max / branch.parameter**2, branch.E1max[0] / 0.01, rtol=1e-9
    )


def test_wrong_requests_for_branches_of_hosts_are_refused_in_one_line():
    host = as_host(SET_6)
    for name, bounds, plane, words in (
        ("u.gapp", (0.1, 0.2), None, "unknown parameter 'gapp'"),
        ("u.m", (-1.0, 2.0), None, "u.m = -1.0 is not allowed"),
        ("u.gap", (0.05, 0.08), ("u.k", 1.0, 2.0), "must hold the system's own value, 668.9"),
    ):
        with pytest.raises(nv.RequestError, match=words):
            nv.continue_branch(host, name, bounds, plane=plane)


def test_a_branch_that_begins_on_a_bound_holds_its_first_point_once(frame):
    (orbit,) = (one for one in frame.orbits_at(12.69) if one.stable)
    there = frame.request.system.with_(omega=12.69)
    options = {"start": orbit.state, "period": 1, "step": 0.1, "quiet": True}
    gaps = there.parameters["b.gap"], 0.0205
    (branch,) = nv.continue_branch(there, "b.gap", gaps, **options).branches
    assert branch.ends == ("bound", "bound")
    assert branch.parameter[0] == gaps[0]
    assert (np.diff(branch.parameter) > 0.0).all()


def test_monitors_of_a_host_lie_where_simulated_orbits_have_them(frame):
    (orbit,) = (one for one in frame.orbits_at(12.69) if one.stable)
    there = frame.request.system.with_(omega=12.69)
    options = {"start": orbit.state, "period": 1, "step": 0.1, "quiet": True}
    (branch,) = nv.continue_branch(there, "b.gap", (0.0195, 0.0205), **options).branches
    level = 0.5 * (branch.E1max[0] + branch.E1max[-1])
    path = nv.continue_branch(
        there, "b.gap", (0.0195, 0.0205), monitors={"E1max": level}, **options
    )
    rows = path.special_points
    at = rows.monitor == f"E1max = {level:g} J"
    assert at.sum() == 1
    (value,), (state,) = rows.value[at], rows.state[at]
    assert orbit_energy(there.with_(**{"b.gap": float(value)}), state) == pytest.approx(level)


def orbit_energy(system, state):
    how = {"start": state, "record": ("energy",), "tolerance": 1e-12, "quiet": True}
    return nv.simulate(system, 1, **how).E1max
