"""Records of branches beside an independent integrator, with contacts at phase zero."""

import numpy as np
import pytest
import twin

import nlds_vines as nv


def assert_records_are_those_of_the_twin(system, branch):
    """Compare every record of every orbit with those of its second n periods by the twin.

    A contact under way at phase zero began in the first n periods, so the twin sees it whole.
    """
    n, omegas = branch.period, branch.parameter
    models = [
        twin.model_of({**system.parameters, "K": system.K, "omega": omega}) for omega in omegas
    ]
    lanes = twin.follow_all(models, branch.states, 2 * n)
    for i, (course, omega) in enumerate(zip(lanes, omegas, strict=True)):
        period = 2.0 * np.pi / omega
        touch, depth = course.contacts[:, 1], course.contacts[:, 4]
        force = system.K * float(depth.max()) ** 1.5 if len(depth) else 0.0
        assert branch.largest_force[i] == pytest.approx(force, rel=1e-9)
        cycle = course.touches[course.touches[:, 1] >= n * period]
        assert branch.impacts[i].sum() == len(cycle) == (touch < n * period).sum()
        speeds = cycle[:, 3].astype(float)
        assert branch.fastest_impact[i] == pytest.approx(speeds.max(initial=0.0), rel=1e-9)
        assert branch.softest_impact[i] == pytest.approx(speeds.min(initial=np.inf), rel=1e-9)
        misses = -course.misses[:, 2].astype(float)
        assert branch.clearance[i] == pytest.approx(misses.min(initial=np.inf), rel=1e-9)
        assert branch.E1max[i] == pytest.approx(float(course.E1max), rel=1e-9)
        assert branch.E2max[i] == pytest.approx(float(course.E2max), rel=1e-9)


def test_a_contact_that_straddles_phase_zero_counts_whole():
    """Its first part alone gave 289 N for 30,680 N at 6.2305 rad/s."""
    system = nv.load_system("ssul-set6", omega=6.23)
    path = nv.continue_branch(system, parameter="omega", bounds=(6.22, 6.24), step=0.2, quiet=True)
    (branch,) = path.branches
    inside = branch.states[:, 2] - branch.states[:, 0] < system.parameters["V"]
    assert 1 < inside.sum() < len(inside) - 1
    assert_records_are_those_of_the_twin(system, branch)


def test_a_contact_that_never_ends_has_a_force():
    """A pressed damper rests on the obstacle for whole periods, without an impact."""
    system = nv.load_system("ssul-set6", omega=6.28, C=-0.01, P=1.0)
    (branch,) = nv.continue_branch(
        system, parameter="omega", bounds=(6.2, 6.3), step=0.5, quiet=True
    ).branches
    assert (branch.impacts == 0).all()
    omegas = branch.parameter
    models = [twin.model_of({**system.parameters, "K": system.K, "omega": w}) for w in omegas]
    for course, force in zip(
        twin.follow_all(models, branch.states, 1), branch.largest_force, strict=True
    ):
        (contact,) = course.contacts
        assert force == pytest.approx(system.K * float(contact[4]) ** 1.5, rel=1e-9)
