"""Scans over initial conditions: attractors, early stops, what a sample missed, numbers."""

from dataclasses import replace

import numpy as np
import pytest
from planes import ALONG, AMPLITUDE, PLANE
from rigid import CASES
from support import as_host

import nlds_vines as nv
from nlds_vines.__main__ import main
from nlds_vines.bifurcation import attractors
from nlds_vines.bifurcation.attractors import AttractorTable
from nlds_vines.bifurcation.blocks import blocks_of
from nlds_vines.bifurcation.run import Computer
from nlds_vines.explore.map_data import stored
from nlds_vines.explore.page_state import sliders_of
from nlds_vines.model.labels import finals
from nlds_vines.transients.ensemble import share_interval
from nlds_vines.upkeep.rerun import differing
from scans import scan_of

pytestmark = pytest.mark.kernels

CHAOS = {
    **PLANE, "system": "ssul-set6", "set": {"omega": 7.36},
    "vary": {"v2_0": {"start": -0.5, "stop": 0.5, "num": 12}},
}  # fmt: skip


@pytest.fixture(scope="module")
def plane(tmp_path_factory):
    return nv.scan(PLANE, to=tmp_path_factory.mktemp("basins") / "plane.h5", quiet=True)


@pytest.fixture(scope="module")
def along(tmp_path_factory):
    return nv.scan(ALONG, to=tmp_path_factory.mktemp("basins") / "along.h5", quiet=True)


def arrays_of(scan):
    """Return what a scan's archive holds, by name."""
    with nv.read(nv.scan(scan, quiet=True)) as view:
        return {name: view[name] for name in view.names}


def test_the_attractors_and_their_energies_are_those_of_the_closed_form_and_of_orbits(plane):
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
        energies, points = view["attractor_E1max"], view["attractor_point"]
        assert "attractor_E2max" not in view
        assert (view["attractor_label"][attractor] == view["label"]).all()
        assert (view["arrival"] >= 0).all()
        assert np.median(view["arrival"]) < 100  # of the 720 periods of plain following
    assert np.allclose(np.sort(values, axis=0), np.sort(stable["multipliers"], axis=0), atol=1e-8)
    assert shares.tolist() == [(attractor == k).mean() for k in (0, 1)]
    assert (shares > 0.1).all()
    # their largest energies are those of their orbits
    system = nv.load_system("impact-oscillator", omega=1.5, P=AMPLITUDE)
    for energy, point in zip(energies, points, strict=True):
        settled = nv.simulate(
            system, 10, start=tuple(point), transient=200, record=["energy"], quiet=True
        )
        assert energy == pytest.approx(settled.E1max, rel=1e-9)
    assert energies[0] != pytest.approx(energies[1], rel=0.01)


def test_chaos_has_the_energies_of_an_orbit_of_it():
    arrays = arrays_of({**CHAOS, "record": {"want": ["attractor", "energy"]}})
    number = arrays["attractor_label"].tolist().index("chaos")
    cells = arrays["attractor"][:, 0] == number
    for name in ("E1max", "E2max"):  # all cells are the sample here
        assert arrays[f"attractor_{name}"][number] == arrays[name][cells, 0][0]


def test_other_records_do_not_change_the_attractors(plane):
    want = ["section", "energy", "regime", "attractor"]
    other = arrays_of({**PLANE, "record": {"want": want}})
    with nv.read(plane) as view:
        for name in ("attractor", "arrival", "attractor_share", "attractor_point"):
            assert np.array_equal(view[name], other[name])
        assert other["section"].shape == (24, 20, 1, 120, 2)
        assert "E1max" in other
        assert "E1max" not in view
        assert "periodicity" not in view


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


def test_an_attractor_keeps_its_number_when_its_label_changes():
    """2T,1 becomes 4T,2 by a period doubling."""
    vary, start = {"P": {"values": [2.1, 2.2]}}, {"policy": "random", "count": 20}
    arrays = arrays_of({**PLANE, "set": {"omega": 2.5}, "vary": vary, "start": start})
    assert arrays["attractor_label"].tolist() == [["T,0", "2T,1"], ["T,0", "4T,2"]]


def test_the_orbit_of_a_cell_and_of_the_page_begins_where_the_axes_say(plane):
    with nv.read(plane) as view:
        x, v = view["x_0"][3], view["v_0"][7]
    orbit = nv.orbit_of(plane, x_0=x, v_0=v, quiet=True)
    system = nv.load_system("impact-oscillator", omega=1.5, P=AMPLITUDE)
    again = nv.simulate(system, 120, start=(x, v), transient=600, quiet=True)
    assert np.array_equal(orbit.section, again.section)
    # and so does the page of an archive
    archive = stored(plane)
    cell = (3, 7)
    start = archive.start_of(cell, 0, archive.system_of(cell))
    with nv.read(plane) as view:
        assert start.state == (view["x_0"][3], view["v_0"][7])
    assert start.words == f"x_0 = {start.state[0]:g}, v_0 = {start.state[1]:g}"
    assert [axis.name for axis in archive.scan.axes] == ["x_0", "v_0"]
    assert [spec.name for spec in sliders_of(archive)][:2] == ["x_0", "v_0"]


def test_a_plane_has_measures_and_random_starts_an_interval(plane, along, error_of):
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
    # random starts have an interval
    document = {**PLANE, "set": {"omega": 1.5}, "vary": {"P": {"values": [AMPLITUDE]}}}
    document["start"] = {"policy": "random", "count": 200, "seed": 4}
    measures = nv.basin_measures(nv.scan(document, quiet=True))
    for basin in measures.basins:
        assert (basin.low, basin.high) == share_interval(basin.count, 200)
    assert measures.entropy is None
    # along a parameter, a value of it is given
    one = {"vary": {"v_0": {"values": [0.0]}}, "record": {"want": ["regime"]}}
    plain = nv.scan({**PLANE, **one}, quiet=True)
    assert "attractor 1, T,1" in repr(nv.basin_measures(along, P=0.51))
    for archive, place, words in (
        (plain, {}, "holds no attractor: scan with --record attractor"),
        (along, {}, "P is missing"),
        (along, {"omega": 1.0}, "unknown varied parameter"),
        (along, {"P": 0.9}, "P = 0.9 lies outside the scan: 0.3 to 0.6"),
    ):
        assert words in error_of(nv.basin_measures, archive, **place)


STARTS = {"policy": "random", "count": 60, "seed": 3}


def requested(system, vary, start=STARTS, **changes):
    return scan_of(system, ["attractor"], vary, start, changes=changes)


REQUESTS = {
    "period one and chaos": requested("ssul-set6", {"omega": [7.36]}),
    "T,0 and 4T,2": requested("ssul-set6", {"omega": [7.66, 7.7]}),
    "after transient chaos": requested("ssul-set6", {"omega": [7.6]}),
    "restitution": requested("impact-oscillator", {"P": [0.7]}, omega=1.5),
}


@pytest.mark.parametrize("scan", REQUESTS.values(), ids=list(REQUESTS))
def test_early_stops_end_as_plain_verdicts_do(scan, monkeypatch):
    monkeypatch.setattr(attractors, "SAMPLE", 20)
    assert attractors.sample_size(scan) == 20
    early, plain = Computer(scan), Computer(replace(scan, want=("regime", "evidence")))
    orbits = early.orbits(np.arange(scan.lanes))
    stopped, verdicts = early.lanes(*orbits), plain.lanes(*orbits)
    labels = finals(verdicts["label"])
    assert (stopped["label"] == labels).all()
    closed = np.flatnonzero([attractors.period_of(label) == 1 for label in labels[:, 0]])
    points = verdicts["orbit_point"][closed, 0]  # of nT, the point of another section may be given
    assert np.allclose(stopped["end_state"][closed, 0], points, rtol=1e-7, atol=1e-12)
    closed = np.array([attractors.period_of(label) > 0 for label in labels[:, 0]])
    arrival = stopped["arrival"][:, 0]
    assert (arrival[closed] >= 0).all()
    assert (arrival[~closed] == -1).all()
    assert np.median(arrival[closed]) < 350


def test_threads_and_neighbors_change_nothing():
    computer = Computer(REQUESTS["T,0 and 4T,2"])
    cells, starts, places = computer.orbits(np.arange(120))
    every = computer.lanes(cells, starts, places)
    for lane in (0, 60, 119):
        one = slice(lane, lane + 1)
        alone = Computer(REQUESTS["T,0 and 4T,2"]).lanes(cells[one], starts[one], places[one])
        for name in ("label", "arrival", "end_state"):
            assert np.array_equal(alone[name][0], every[name][lane])


def test_mirrored_twins_are_two_attractors():
    """Between two equal stops, what is not its own mirror image has a twin: T,2 and T,3 both do."""
    stops = {"kind": "oscillator-2", "omega": 1.2, "P": 2.0, "m": 1.0, "k": 1.0, "c": 0.05}
    stops |= {"C": 0.5, "C_2": 0.5, "K": 20.0}
    arrays = arrays_of(requested(stops, {"P": [2.0]}, {**STARTS, "count": 30}))
    labels = arrays["attractor_label"][0].tolist()
    assert labels.count("T,2") == labels.count("T,3") == 2
    assert set(arrays["attractor"][0].tolist()) == set(range(len(labels)))
    for label in ("T,2", "T,3"):
        one, other = arrays["attractor_E1max"][0][[word == label for word in labels]]
        assert one == pytest.approx(other, rel=1e-7)  # which is why they are no features


def test_two_tori_of_one_system_are_two_attractors():
    arrays = arrays_of(requested("ssul-set6", {"omega": [7.375]}))
    assert arrays["attractor_label"].tolist() == [["quasiperiodic", "quasiperiodic"]]
    assert min(arrays["attractor_share"][0]) > 0.2
    assert arrays["attractor_margin"].min() > 2.0
    # their energies of 100,000 periods are 98.291 and 124.738 J
    energies = sorted(arrays["attractor_E1max"][0].tolist())
    assert energies == pytest.approx([98.291, 124.738], rel=0.01)


def test_an_attractor_that_no_start_comes_to_is_carried_on():
    """As if at the second value both orbits had come to T,0."""
    vary = {"P": [0.5, 0.55, 0.6], "v_0": [0.0, 3.0]}
    scan = requested("impact-oscillator", vary, "rest", omega=1.5)
    (block,) = blocks_of(scan)
    arrays = Computer(scan).block(block)
    assert arrays["label"][..., 0].tolist() == [["T,0", "T,1"]] * 3
    for name in ("label", "end_state"):
        arrays[name][1, 1] = arrays[name][1, 0]
    table = AttractorTable(Computer(scan).ends, [(block, arrays)])
    assert table.numbers[..., 0].tolist() == [[0, 1], [0, 0], [0, 1]]
    values = {entry.name: array for entry, array in table.contents}
    assert values["attractor_label"].tolist() == [["T,0", "T,1"]] * 3
    assert values["attractor_share"].tolist() == [[0.5, 0.5], [1.0, 0.0], [0.5, 0.5]]


@pytest.fixture
def sample_of_one(monkeypatch):
    """Let one orbit of each system be judged before others may stop early."""
    monkeypatch.setattr(attractors, "SAMPLE", 1)
    monkeypatch.setattr(attractors, "LEAST", 1)


def test_what_one_orbit_has_missed_has_a_number_at_last(sample_of_one, plane):
    one = arrays_of(PLANE)
    with nv.read(plane) as view:
        all_of = {name: view[name] for name in view.names}
    assert sorted(one["attractor_label"].tolist()) == ["T,0", "T,1"]
    assert (one["attractor"] >= 0).all()
    assert (one["arrival"] >= 0).all()
    same = np.array([all_of["attractor_label"].tolist().index(x) for x in one["attractor_label"]])
    assert (same[one["attractor"]] == all_of["attractor"]).all()
    assert np.array_equal(one["label"], all_of["label"])
    assert np.allclose(one["attractor_point"], all_of["attractor_point"][same], atol=1e-9)
    assert np.allclose(one["attractor_E1max"], all_of["attractor_E1max"][same], rtol=1e-9)
    assert one["attractor_share"].tolist() == all_of["attractor_share"][same].tolist()


def test_it_keeps_its_number_along_a_parameter_also_in_shards(sample_of_one, tmp_path):
    whole = nv.scan(ALONG, to=tmp_path / "whole.h5", quiet=True)
    with whole.read() as view:
        arrays = {name: view[name] for name in view.names}
    labels = arrays["attractor_label"]
    assert (arrays["attractor"] >= 0).all()
    for k in range(labels.shape[1]):
        assert len(set(labels[:, k].tolist()) - {""}) == 1
    assert sorted(set(labels.ravel().tolist())) == ["", "T,0", "T,1"]
    assert labels.shape[1] == 2
    names = labels[np.arange(4)[:, np.newaxis], arrays["attractor"][..., 0]]
    assert np.array_equal(names, arrays["label"][..., 0])
    # shards make the same archive
    scan, path = tmp_path / "scan.toml", tmp_path / "parts.h5"
    scan.write_text(nv.load_scan(ALONG).to_toml())
    command = ["bifurcation", str(scan), "-o", str(path), "--quiet"]
    assert main([*command, "--shard", "2/2", "--threads", "1"]) == 0
    assert main([*command, "--shard", "1/2"]) == 0
    assert differing(whole, path) == []


def test_chaos_that_was_missed_has_a_number(sample_of_one):
    arrays = arrays_of(CHAOS)
    names = arrays["attractor_label"][arrays["attractor"][..., 0]]
    assert set(arrays["label"].ravel().tolist()) - {"chaos"}
    assert np.array_equal(names, [str(x).split(" to ")[-1] for x in arrays["label"][:, 0]])
    assert np.isfinite(arrays["attractor_E1max"]).all()


def test_a_kind_as_a_host_has_its_basins_arrivals_and_attractors():
    system = nv.load_system("impact-oscillator", omega=1.5, P=0.5)
    places, speeds = np.linspace(-1, 0.9, 6), np.linspace(-3, 3, 7)
    axes = {"P": [0.3, 0.5], "v_0": speeds}, {"force.x": [0.3, 0.5], "v_x_0": speeds}
    plane = {"x_0": places, "v_0": speeds}, {"x_0": places, "v_x_0": speeds}
    for one, other in (axes, plane):
        kind, host = (
            arrays_of(nv.load_scan(each, {"vary": vary, "record": {"want": ["attractor"]}}))
            for each, vary in ((system, one), (as_host(system), other))
        )
        for name in ("attractor", "arrival", "attractor_label", "attractor_impacts"):
            np.testing.assert_array_equal(host[name], kind[name], name)
        assert {*np.unique(kind["attractor"])} == {0, 1}
        for name in ("point", "multipliers", "E1max", "share"):
            values = host[f"attractor_{name}"]
            np.testing.assert_allclose(values, kind[f"attractor_{name}"], rtol=1e-8, atol=1e-9)
