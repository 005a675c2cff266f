"""Numbers of the structure by name: floor2.k, host.K, host.ratio, in systems, files and runs."""

import pickle

import numpy as np
import pytest

import nlds_vines as nv
from nlds_vines.errors import RequestError
from nlds_vines.model.catalog import any_system_from

MASSES, SPRINGS = [1e4, 1.1e4, 1.2e4], [8e6, 7e6, 6e6]
CELL = nv.Damper("cell", attached_to="roof", m=900.0, k=2e4, walls=[nv.Wall(0.02, K=1e8)])


def of(host, **force):
    return nv.System.from_host(host, [CELL], force=force or {"roof": 700.0}, omega=12.6)


def frame(**options):
    return nv.shear_frame(MASSES, SPRINGS, **({"ratio": 0.02} | options))


def assert_same(host, other):
    for name in ("M", "K", "C", "inertia", "frequencies"):
        np.testing.assert_array_equal(getattr(host, name), getattr(other, name), err_msg=name)


@pytest.mark.parametrize(
    "options", [{}, {"ratio": None, "rayleigh": (0.1, 1e-4)}, {"ratio": [0.02, 0.03, 0.04]}]
)
def test_a_storey_that_changes_is_that_of_another_frame(options):
    system = of(frame(**options)).with_(**{"floor2.k": 5e6, "roof.m": 1.3e4})
    other = nv.shear_frame([1e4, 1.1e4, 1.3e4], [8e6, 5e6, 6e6], **({"ratio": 0.02} | options))
    assert_same(system.host, other)
    assert system.parameters["floor2.k"] == 5e6
    assert system.to_table()["host"] == of(other).to_table()["host"]


@pytest.mark.parametrize("cyclic", [False, True])
def test_springs_of_chains_and_the_influence_stay(cyclic):
    chain = nv.chain(
        [1.0] * 4, [0.5, 0.6, 0.7, 0.8], grounds=1.0, cyclic=cyclic, influence=[1, 0, 1, 0]
    )
    other = nv.chain(
        [1.0] * 4, [0.5, 0.6, 0.9, 0.8], grounds=1.0, cyclic=cyclic, influence=[1, 0, 1, 0]
    )
    assert_same(chain.with_numbers({"x3.k": 0.9}), other)
    system = nv.System.from_host(
        chain, [], base={"acceleration": 1.0, "influence": {"x1": 0.5, "x2": 0.5}}, omega=2.0
    )
    changed = system.with_(**{"x3.k": 0.9})
    np.testing.assert_array_equal(changed.host.influence, [0.5, 0.5, 0.0, 0.0])


def test_factors_act_on_the_matrices_of_any_host():
    beam = nv.beam(1.0, 65.6, 1.18, elements=6, ratio=0.02).reduced(4)
    changed = beam.with_numbers({"host.K": 1.21, "host.M": 4.0})
    np.testing.assert_allclose(changed.frequencies, beam.frequencies * 1.1 / 2.0, rtol=1e-13)
    np.testing.assert_allclose(changed.damping_ratios, 0.02, rtol=1e-12)
    np.testing.assert_array_equal(changed.inertia, 4.0 * beam.inertia)
    ratios = beam.with_numbers({"host.C": 1.5}).damping_ratios
    np.testing.assert_allclose(ratios, 0.03, rtol=1e-12)
    plain = nv.Host([[2.0, 0.0], [0.0, 1.0]], [[3.0, -1.0], [-1.0, 1.0]], C=np.eye(2))
    np.testing.assert_array_equal(plain.with_numbers({"host.C": 2.0}).C, 2.0 * np.eye(2))
    again = changed.with_numbers({"host.M": 1.0, "host.K": 1.0})
    assert_same(again, beam)


def test_files_and_pickles_keep_what_a_host_is_made_of():
    system = of(frame()).with_(**{"floor2.k": 5e6, "host.K": 1.1, "host.ratio": 0.03})
    for again in (pickle.loads(pickle.dumps(system)), any_system_from(system.to_table())):
        assert_same(again.host, system.host)
        assert again.parameters == system.parameters
    changed = again.with_(**{"floor2.k": 7e6, "host.K": 1.0, "host.ratio": 0.02})
    assert_same(changed.host, frame())


def test_tables_keep_an_influence_beside_factors_and_a_damping_matrix():
    scaled = frame().with_numbers({"host.M": 2.0})
    base = {"acceleration": 1.0, "influence": {"roof": 0.5}}
    system = nv.System.from_host(scaled, [], base=base, omega=2.0)
    np.testing.assert_array_equal(system.host.influence, [0.0, 0.0, 0.5])
    assert_same(pickle.loads(pickle.dumps(system)).host, system.host)
    pandas = pytest.importorskip("pandas")
    C = pandas.DataFrame(np.diag([1.0, 2.0, 3.0]))
    damped = of(nv.shear_frame(MASSES, SPRINGS, C=C))
    assert damped.to_table()["host"]["C"] == [1.0, 2.0, 3.0]
    assert_same(any_system_from(damped.to_table()).host, damped.host)


def test_names_and_ranges_are_checked(error_of):
    system = of(frame())
    assert "did you mean 'floor2.k'" in error_of(system.with_, **{"floor9.k": 1.0})
    assert "must be >= 0" in error_of(system.with_, **{"host.K": -1.0})
    assert "must be > 0" in error_of(system.with_, **{"roof.m": 0.0})
    plain = of(nv.Host([[1.0]], [[1.0]], dofs=["roof"]))
    assert "unknown parameter 'roof.k'" in error_of(plain.with_, **{"roof.k": 1.0})
    table = system.to_table()
    table["host"]["factors"] = {"K": "stiff"}
    with pytest.raises(RequestError, match=r"factors\.K"):
        any_system_from(table)


@pytest.mark.kernels
def test_numbers_of_the_structure_vary_in_scans_loads_and_tunings():
    values = [5e6, 7e6, 9e6]
    how = {"sampling": {"transient": 20, "periods": 4}, "quiet": True}
    records = ["section", "energy", "response"]
    scan = nv.scan(of(frame()), vary={"floor2.k": values}, record=records, **how).to_xarray()
    for i, value in enumerate(values):
        other = of(nv.shear_frame(MASSES, [8e6, value, 6e6], ratio=0.02))
        one = nv.scan(other, vary={"omega": [12.6]}, record=records, **how).to_xarray()
        np.testing.assert_array_equal(scan["section"][i], one["section"][0])
        np.testing.assert_array_equal(scan["x_max"][i], one["x_max"][0])
    load = {"impulse": 500.0}
    history = {"load": load | {"on": "roof"}, "duration": 2.0, "quiet": True}
    over = nv.response_history(of(frame()), vary={"host.K": {"values": [0.9, 1.0]}}, **history)
    alone = nv.response_history([of(frame())], **history)
    nominal = alone["host"]
    np.testing.assert_allclose(over["roof.x_max"][0, 1], nominal.numbers["roof.x_max"], rtol=1e-12)
    assert over["roof.x_max"][0, 0] > over["roof.x_max"][0, 1]


def test_a_host_without_damping_takes_a_ratio():
    """Its ratio is 0 until it is set, also along an axis; a stated damping matrix stays."""
    M, K = np.diag([2.0, 1.0]), np.array([[30.0, -10.0], [-10.0, 10.0]])
    for host in (nv.Host(M, K, dofs=["a", "b"]), nv.shear_frame([2.0, 1.0], [20.0, 10.0])):
        place = host.dofs[-1]
        ball = nv.Damper("ball", place, m=0.1, walls=[nv.Wall(0.1, law="restitution", e=0.5)])
        system = nv.System.from_host(host, [ball], force={place: 1.0}, omega=2.0)
        assert "host.ratio" not in system.parameters
        damped = system.with_(**{"host.ratio": 0.03})
        assert damped.parameters["host.ratio"] == 0.03
        again = type(host)(host.M, host.K, ratio=0.03, dofs=host.dofs)
        np.testing.assert_allclose(damped.host.C, again.C, rtol=1e-14)
        assert system.with_axes(["host.ratio"]).parameters["host.ratio"] == 0.0
        stiffer = system.with_(**{"host.K": 4.0}).with_(**{"host.ratio": 0.03})
        np.testing.assert_allclose(stiffer.host.C, 2.0 * damped.host.C, rtol=1e-12)
    stated = nv.Host(M, K, 0.01 * K, dofs=["a", "b"])
    assert "host.ratio" not in stated.settable
