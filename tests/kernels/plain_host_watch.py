"""Records of hosts without compiling: bounds of derivatives, and cells that are skipped."""

import numpy as np
import pytest
import scipy.linalg

import nlds_vines as nv
from nlds_vines.engine.host_orbits import HostOrbits
from nlds_vines.kernels.hosts import host_orbit
from nlds_vines.kernels.hosts.grid import host_grid, matrix_of
from nlds_vines.kernels.hosts.host_watch import DERIVATIVES, bound_rates, fourth_of, host_watch

START = np.random.default_rng(1).normal(size=14) * np.tile([0.01, 0.2], 7)  # all modes move


def system_under(force):
    frame = nv.shear_frame([1000.0] * 6, [8e5] * 6, ratio=0.005)
    walls = [nv.Wall(0.03, K=3e6), nv.Wall(0.02, "-", law="restitution", e=0.6)]
    cell = nv.Damper("cell", "roof", m=60.0, k=300.0, c=40.0, walls=walls)
    return nv.System.from_host(frame, [cell], omega=4.0, **force)


FORCES = [{"force": {"roof": 900.0}}, {"base": {"acceleration": 0.3}}]


@pytest.mark.parametrize("force", FORCES)
def test_derivatives_stay_within_their_bounds_in_a_coarse_cell(force):
    """Those of velocities, and the fourth ones of all quantities, along an exact motion."""
    orbits = HostOrbits(system_under(force))
    body, names = orbits.body, ["roof", "floor5-floor1", "cell"]
    records = orbits.records(True, names)
    grid, _ = host_grid(body, 1)
    watch = host_watch(body, grid, orbits.walls, records)
    A, size = matrix_of(body), body.size
    coarse, y, drive = grid.h * 2**grid.levels, orbits.start(START), np.array([0.8, -0.6])
    bound_rates(body, grid, watch, y, drive)
    bounds = watch.bounds.reshape(DERIVATIVES, -1)
    fourth = [fourth_of(body, watch, q, y, coarse) for q in range(2 + len(records.grounds))]
    largest, largest_fourth = np.zeros((DERIVATIVES, size)), np.zeros(len(fourth))
    rows, count = records.rows.reshape(-1, size), len(records.squares)
    assert count == len(names) * (1 if "force" in force else 2)  # and absolute displacements
    of_x, of_a = records.grounds[:count], records.grounds[count:]
    for share in np.linspace(0, 1, 31):
        jet = [scipy.linalg.expm(A * (share * coarse)) @ np.concatenate([y, drive])]
        for _ in range(DERIVATIVES):
            jet.append(A @ jet[-1])
        X, V, f = np.array([[z[:size], z[size : 2 * size], 0 * z[:size] + z[2 * size]] for z in jet]
                           ).transpose(1, 0, 2)  # fmt: skip
        largest = np.maximum(largest, np.abs(V[:DERIVATIVES]))
        squares = [V[0] * V[4] + 4 * V[1] * V[3] + 3 * V[2] ** 2,
                   X[0] * X[4] + 4 * X[1] * X[3] + 3 * X[2] ** 2]  # fmt: skip
        by_coordinate = records.masses * squares[0] + records.springs * squares[1]
        values = [by_coordinate[: body.modes].sum(), by_coordinate[body.modes :].sum()]
        values += [*(rows @ X[4] + of_x * f[4, 0])]
        values += [*(rows[: len(names)] @ V[5] + of_a * f[4, 0])]
        largest_fourth = np.maximum(largest_fourth, np.abs(values))
    assert np.all(largest <= bounds[:, :size] * (1 + 1e-12))
    assert np.all(largest_fourth <= np.array(fourth) * (1 + 1e-12))
    assert np.all(bounds[0, : body.modes] < 2 * largest[0, : body.modes])  # and close


@pytest.mark.parametrize("force", FORCES)
def test_cells_that_are_skipped_hold_no_largest_value(force, monkeypatch):
    """Beside records for which each smallest cell is expanded."""
    record, names = ["section", "energy", "response"], ["roof", "floor5-floor1", "cell"]
    system = system_under(force)

    def values():
        orbit = nv.simulate(system, 1, start=START, record=record, of=names, quiet=True)
        response = orbit.response.values()
        return np.array([orbit.E1max, *orbit.E2max, *response]), orbit.section

    largest, section = values()
    monkeypatch.setattr(host_orbit, "is_quiet", lambda *arguments: False)
    expanded, same = values()
    assert largest == pytest.approx(expanded, rel=1e-13)
    assert np.array_equal(section, same)
