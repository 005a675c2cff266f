"""Branches of hosts: those of kinds, and of a frame with two dampers."""

import numpy as np
import pytest
from support import as_host

import nlds_vines as nv
from nlds_vines.continuation.host_section_map import HostSectionMap
from nlds_vines.continuation.section_map import SectionMap
from nlds_vines.orbits.solver_settings import Settings

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
        ({}, "C", (0.06, 0.08), ["PD", "PD", "GR"]),
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
