"""Scans over initial conditions, and the attractors that their cells are drawn to."""

from dataclasses import replace

import numpy as np
import pytest
from planes import ALONG, AMPLITUDE, PLANE
from rigid import CASES

import nlds_vines as nv
from nlds_vines.bifurcation.attractor_ends import sample_size
from nlds_vines.bifurcation.run import Computer
from nlds_vines.errors import RequestError
from nlds_vines.explore.map_data import stored
from nlds_vines.explore.page_state import sliders_of
from nlds_vines.model.labels import finals
from nlds_vines.transients.ensemble import share_interval


@pytest.fixture(scope="module")
def plane(tmp_path_factory):
    path = tmp_path_factory.mktemp("basins") / "plane.h5"
    nv.scan(PLANE, to=path, quiet=True)
    return path


@pytest.fixture(scope="module")
def along(tmp_path_factory):
    path = tmp_path_factory.mktemp("basins") / "along.h5"
    nv.scan(ALONG, to=path, quiet=True)
    return path


@pytest.mark.kernels
def test_the_attractors_are_those_of_the_closed_form(plane):
    (case,) = (c for c in CASES if (c["omega"], c["e"], c["n"]) == (1.5, 0.8, 1))
    assert case["fold_A"] < AMPLITUDE < case["grazing_A"]
    (stable,) = (
        orbit
        for orbit in case["orbits"]
        if orbit["A"] == AMPLITUDE and abs(complex(*orbit["multipliers"][0])) < 1
    )
    with nv.read(plane) as view:
        assert view["attractor_label"].tolist() == ["T,0", "T,1"]
        assert view["attractor_impacts"].tolist() == [0, 1]
        values = view["attractor_multipliers"][1]
        shares = view["attractor_share"]
        attractor = view["attractor"]
    assert np.allclose(np.sort(values, axis=0), np.sort(stable["multipliers"], axis=0), atol=1e-8)
    assert shares.tolist() == [(attractor == k).mean() for k in (0, 1)]
    assert (shares > 0.1).all()


@pytest.mark.kernels
def test_the_largest_energies_of_attractors_are_those_of_their_orbits(plane, tmp_path):
    with nv.read(plane) as view:
        energies, points = view["attractor_E1max"], view["attractor_point"]
        assert "attractor_E2max" not in view
    system = nv.load_system("impact-oscillator", omega=1.5, P=AMPLITUDE)
    for energy, point in zip(energies, points, strict=True):
        settled = nv.simulate(
            system, 10, start=tuple(point), transient=200, record=["energy"], quiet=True
        )
        assert energy == pytest.approx(settled.E1max, rel=1e-9)
    assert energies[0] != pytest.approx(energies[1], rel=0.01)


@pytest.mark.kernels
def test_chaos_has_the_energies_of_an_orbit_of_it(tmp_path):
    document = {
        **PLANE,
        "system": "ssul-set6",
        "set": {"omega": 7.36},
        "vary": {"v2_0": {"start": -0.5, "stop": 0.5, "num": 12}},
        "record": {"want": ["attractor", "energy"]},
    }
    path = nv.scan(document, to=tmp_path / "chaos.h5", quiet=True)
    with nv.read(path) as view:
        number = view["attractor_label"].tolist().index("chaos")
        cells = view["attractor"][:, 0] == number
        for name in ("E1max", "E2max"):
            first = view[name][cells, 0][0]
            assert view[f"attractor_{name}"][number] == first  # all cells are the sample here


@pytest.mark.kernels
def test_labels_are_those_of_plain_following(plane, tmp_path):
    plain = nv.scan({**PLANE, "record": {"want": ["regime"]}}, to=tmp_path / "p.h5", quiet=True)
    with nv.read(plane) as view, nv.read(plain) as other:
        assert (finals(view["label"]) == finals(other["label"])).all()
        names = view["attractor_label"][view["attractor"]]
        assert (names == view["label"]).all()
        arrival = view["arrival"]
    assert (arrival >= 0).all()
    assert np.median(arrival) < 100  # of the 720 periods of plain following


@pytest.mark.long
def test_labels_of_ten_thousand_cells_are_those_of_plain_following():
    document = {
        **PLANE,
        "system": "ssul-set6",
        "set": {"omega": 7.7},
        "vary": {
            "x2_0": {"start": 0.1, "stop": 0.26, "num": 1000},
            "v2_0": {"start": -1.0, "stop": 1.0, "num": 1000},
        },
    }
    scan = nv.load_scan(document)
    chosen = np.sort(np.random.default_rng(1).choice(scan.lanes, 10_000, replace=False))
    computer = Computer(scan)
    early = computer.lanes(*computer.orbits(chosen))["label"]
    plain = Computer(replace(scan, want=("regime",)))
    assert (early == finals(plain.lanes(*plain.orbits(chosen))["label"])).all()


@pytest.mark.kernels
def test_other_records_do_not_change_the_attractors(plane, tmp_path):
    want = ["section", "energy", "regime", "attractor"]
    path = nv.scan({**PLANE, "record": {"want": want}}, to=tmp_path / "all.h5", quiet=True)
    with nv.read(plane) as view, nv.read(path) as other:
        for name in ("attractor", "arrival", "attractor_share", "attractor_point"):
            assert np.array_equal(view[name], other[name])
        assert other["section"].shape == (24, 20, 1, 120, 2)
        assert "E1max" in other
        assert "E1max" not in view
        assert "periodicity" not in view


@pytest.mark.kernels
def test_shares_are_those_of_random_starts(plane):
    """10,000 points drawn in the plane end on T,0 as often as its lattice says."""
    scan = nv.load_scan(PLANE)
    computer = Computer(scan)
    points = np.random.default_rng(5).uniform([-2.0, -3.0], [1.0, 3.0], (10_000, 2))
    starts = np.zeros((10_000, 4))
    starts[:, :2] = starts[:, 2:] = points
    cells = np.repeat(scan.cells().ravel()[:1], 10_000)
    labels = computer.ends.arrays(cells, starts, np.zeros(10_000, np.int64))["label"]
    low, high = share_interval(int((labels == "T,0").sum()), 10_000, 0.999)
    with nv.read(plane) as view:
        share = view["attractor_share"][0]
    edge = 0.03  # a lattice of 480 cells divides a smooth boundary of about 30 of them
    assert low - edge < share < high + edge


@pytest.mark.kernels
def test_numbers_mean_the_same_along_a_parameter(along):
    with nv.read(along) as view:
        labels = view["attractor_label"]
        assert view.dims("attractor_share") == ("P", "number")
        shares, attractor = view["attractor_share"], view["attractor"]
    # T,1 is born in the fold at 0.391
    assert labels.tolist() == [["T,0", ""], ["T,0", "T,1"], ["T,0", "T,1"], ["T,0", "T,1"]]
    assert np.isnan(shares[0, 1])
    assert np.allclose(np.nansum(shares, axis=1), 1.0)
    assert (attractor[0] == 0).all()


@pytest.mark.kernels
def test_an_attractor_keeps_its_number_when_its_label_changes(tmp_path):
    """2T,1 becomes 4T,2 by a period doubling."""
    document = {
        **PLANE,
        "set": {"omega": 2.5},
        "vary": {"P": {"values": [2.1, 2.2]}},
        "start": {"policy": "random", "count": 20},
    }
    path = nv.scan(document, to=tmp_path / "flip.h5", quiet=True)
    with nv.read(path) as view:
        labels = view["attractor_label"]
    assert labels.tolist() == [["T,0", "2T,1"], ["T,0", "4T,2"]]


@pytest.mark.kernels
def test_the_orbit_of_a_cell_begins_where_the_axes_say(plane):
    with nv.read(plane) as view:
        x, v = view["x_0"][3], view["v_0"][7]
    orbit = nv.orbit_of(plane, x_0=x, v_0=v, quiet=True)
    same = nv.simulate(
        "impact-oscillator", 120, start=(x, v), transient=600, quiet=True, record=["section"]
    ).system.with_(omega=1.5, P=AMPLITUDE)
    again = nv.simulate(same, 120, start=(x, v), transient=600, quiet=True)
    assert np.array_equal(orbit.section, again.section)


def test_a_given_state_is_where_other_components_begin():
    document = {
        "system": "ssul-set6",
        "vary": {"x2_0": {"values": [0.01, 0.02]}},
        "start": {"state": [1e-3, 0.1, 9.0, -0.2]},
        "record": {"want": ["section"]},
        "sampling": {"transient": 0, "periods": 1},
    }
    scan = nv.load_scan(document)
    assert scan.start.policy == "state"
    assert nv.load_scan(scan.document()).hash == scan.hash
    starts = Computer(scan).orbits(np.arange(2))[1]
    rest = scan.system.rest
    expected = [[1e-3, 0.1, 1e-3 - (x2 - rest), 0.1 + 0.2] for x2 in (0.01, 0.02)]
    assert np.array_equal(starts, expected)


def test_what_is_not_varied_is_at_rest():
    scan = nv.load_scan(
        {**PLANE, "system": "ssul-set6", "set": {}, "vary": {"v2_0": {"values": [0.5]}}}
    )
    assert Computer(scan).orbits(np.arange(1))[1].tolist() == [[0.0, 0.0, 0.0, -0.5]]


def test_a_sample_is_judged_where_it_is_less_than_half():
    assert sample_size(nv.load_scan(PLANE)) == 200
    # half of its 30 starts would be judged first
    assert sample_size(nv.load_scan(ALONG)) == 0


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"vary": {"x3_0": {"values": [0.0]}}}, "unknown axis 'x3_0'; did you mean 'x_0'"),
        ({"vary": {"x2_0": {"values": [0.0]}}}, "x2_0: kind 'oscillator' has the state x, v"),
        ({"start": {"policy": "random", "count": 3}}, "x_0 is varied, so orbits begin at rest"),
        ({"start": {"policy": "up"}}, "x_0 is varied"),
        ({"vary": {"e": {"values": [0.5]}}, "start": {"policy": "up"}}, "want 'attractor'"),
        ({"start": {"state": [1.0]}}, "must be a list of 4 numbers, or of 2"),
        ({"start": {"state": [1.0, 2.0, 3.0, 4.0]}}, "state has 4 numbers"),
        ({"start": {"policy": "state"}}, "which needs one"),
        ({"start": {"policy": "rest", "state": [0.0, 0.0]}}, "a state belongs to policy 'state'"),
        ({"vary": {"x_0": {"values": [float("inf")]}}}, "x_0 = inf"),
    ],
)
def test_a_wrong_request_is_refused(changes, message, error_of):
    assert message in error_of(nv.load_scan, {**PLANE, **changes})


def test_a_state_on_the_command_line(refusal):
    command = ["bifurcation", "--vary", "x2_0=0:0.1:3", "--record", "attractor", "--dry-run"]
    assert "must be a list of 4 numbers" in refusal(*command, "--start", "0,0,0.1")
    assert "must be a number" in refusal(*command, "--start", "0,one,0,0")


@pytest.mark.kernels
def test_measures_of_a_plane(plane, answer):
    measures = nv.basin_measures(plane, side=10)
    assert [basin.label for basin in measures.basins] == ["T,0", "T,1"]
    assert sum(basin.share for basin in measures.basins) == pytest.approx(1.0)
    assert np.isnan(measures.basins[0].low)  # a lattice is no sample
    assert measures.entropy.boxes == 4
    assert measures.uncertainty is None  # too small a plane
    assert measures.arrived(1e9) == 1.0
    assert measures.arrived(5, 0) + measures.arrived(5, 1) == pytest.approx(measures.arrived(5))
    nearest, axes = measures.basins[0].nearest, (3.0, 6.0)
    assert measures.basins[0].distance == pytest.approx(
        np.hypot(nearest[0] / axes[0], nearest[1] / axes[1])
    )
    with nv.read(plane) as view:
        point = view["attractor_point"][0]
        x, v = (
            np.abs(view[n] - p - w).argmin()
            for n, p, w in zip(("x_0", "v_0"), point, nearest, strict=True)
        )
        assert view["attractor"][x, v, 0] == 1
    assert "attractor 0, T,0" in repr(measures)


@pytest.mark.kernels
def test_measures_along_a_parameter(along, answer):
    assert "attractor 1, T,1" in repr(nv.basin_measures(along, P=0.51))
    with pytest.raises(RequestError, match="P is missing"):
        nv.basin_measures(along)
    with pytest.raises(RequestError, match="unknown varied parameter"):
        nv.basin_measures(along, omega=1.0)
    with pytest.raises(RequestError, match=r"P = 0\.9 lies outside the scan: 0\.3 to 0\.6"):
        nv.basin_measures(along, P=0.9)


@pytest.mark.kernels
def test_random_starts_have_an_interval(tmp_path):
    document = {**PLANE, "set": {"omega": 1.5}, "vary": {"P": {"values": [AMPLITUDE]}}}
    document["start"] = {"policy": "random", "count": 200, "seed": 4}
    path = nv.scan(document, to=tmp_path / "random.h5", quiet=True)
    measures = nv.basin_measures(path)
    for basin in measures.basins:
        assert (basin.low, basin.high) == share_interval(basin.count, 200)
    assert measures.entropy is None


@pytest.mark.kernels
def test_an_archive_without_attractors_is_refused(tmp_path):
    other = nv.scan({**PLANE, "record": {"want": ["regime"]}}, to=tmp_path / "o.h5", quiet=True)
    with pytest.raises(RequestError, match="holds no attractor: scan with --record attractor"):
        nv.basin_measures(other)


@pytest.mark.kernels
def test_the_page_of_an_archive_begins_orbits_where_the_axes_say(plane):
    archive = stored(plane)
    cell = (3, 7)
    start = archive.start_of(cell, 0, archive.system_of(cell))
    with nv.read(plane) as view:
        assert start.state == (view["x_0"][3], view["v_0"][7])
    assert start.words == f"x_0 = {start.state[0]:g}, v_0 = {start.state[1]:g}"
    assert [axis.name for axis in archive.scan.axes] == ["x_0", "v_0"]
    assert [spec.name for spec in sliders_of(archive)][:2] == ["x_0", "v_0"]
