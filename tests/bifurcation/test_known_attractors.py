"""Orbits stop early near cycles that are known, and end where plain verdicts say."""

from dataclasses import replace

import numpy as np
import pytest

import nlds_vines as nv
from nlds_vines.bifurcation import attractor_ends
from nlds_vines.bifurcation.attractor_ends import AttractorTable
from nlds_vines.bifurcation.blocks import blocks_of
from nlds_vines.bifurcation.run import Computer
from nlds_vines.model.labels import finals

pytestmark = pytest.mark.kernels

STARTS = {"policy": "random", "count": 60, "seed": 3}
STOPS = {
    "kind": "oscillator-2",
    "omega": 1.2,
    "P": 2.0,
    "m": 1.0,
    "k": 1.0,
    "c": 0.05,
    "C": 0.5,
    "C_2": 0.5,
    "K": 20.0,
}


def scan_of(system, vary, start=STARTS, **changes):
    document = {"title": "of a test", "system": system, "vary": vary, "start": start}
    return nv.load_scan({**document, "record": {"want": ["attractor"]}, **changes})


CASES = {
    "period one and chaos": scan_of("ssul-set6", {"omega": {"values": [7.36]}}),
    "T,0 and 4T,2": scan_of("ssul-set6", {"omega": {"values": [7.66, 7.7]}}),
    "after transient chaos": scan_of("ssul-set6", {"omega": {"values": [7.6]}}),
    "restitution": scan_of("impact-oscillator", {"P": {"values": [0.7]}}, set={"omega": 1.5}),
}


def attractors_of(scan, tmp_path):
    with nv.read(nv.scan(scan, to=tmp_path / "scan.h5", quiet=True)) as view:
        return {name: view[name] for name in view.names}


@pytest.mark.parametrize("scan", CASES.values(), ids=list(CASES))
def test_early_stops_end_as_plain_verdicts_do(scan, monkeypatch):
    monkeypatch.setattr(attractor_ends, "SAMPLE", 20)
    assert attractor_ends.sample_size(scan) == 20
    early, plain = Computer(scan), Computer(replace(scan, want=("regime", "evidence")))
    orbits = early.orbits(np.arange(scan.lanes))
    stopped, verdicts = early.lanes(*orbits), plain.lanes(*orbits)
    labels = finals(verdicts["label"])
    assert (stopped["label"] == labels).all()
    closed = np.flatnonzero([attractor_ends.period_of(label) == 1 for label in labels[:, 0]])
    points = verdicts["orbit_point"][closed, 0]  # of nT, the point of another section may be given
    assert np.allclose(stopped["end_state"][closed, 0], points, rtol=1e-7, atol=1e-12)
    closed = np.array([attractor_ends.period_of(label) > 0 for label in labels[:, 0]])
    arrival = stopped["arrival"][:, 0]
    assert (arrival[closed] >= 0).all()
    assert (arrival[~closed] == -1).all()
    assert np.median(arrival[closed]) < 350


def test_threads_and_neighbors_change_nothing():
    computer = Computer(CASES["T,0 and 4T,2"])
    cells, starts, places = computer.orbits(np.arange(120))
    every = computer.lanes(cells, starts, places)
    for lane in (0, 60, 119):
        one = slice(lane, lane + 1)
        alone = Computer(CASES["T,0 and 4T,2"]).lanes(cells[one], starts[one], places[one])
        for name in ("label", "arrival", "end_state"):
            assert np.array_equal(alone[name][0], every[name][lane])


def test_mirrored_twins_are_two_attractors(tmp_path):
    """Between two equal stops, what is not its own mirror image has a twin: T,2 and T,3 both do."""
    scan = scan_of(STOPS, {"P": {"values": [2.0]}}, {**STARTS, "count": 30})
    arrays = attractors_of(scan, tmp_path)
    labels = arrays["attractor_label"][0].tolist()
    assert labels.count("T,2") == labels.count("T,3") == 2
    assert set(arrays["attractor"][0].tolist()) == set(range(len(labels)))
    energies = {
        label: arrays["attractor_E1max"][0][[word == label for word in labels]]
        for label in ("T,2", "T,3")
    }
    for pair in energies.values():
        assert pair[0] == pytest.approx(pair[1], rel=1e-7)  # which is why they are no features


def test_two_tori_of_one_system_are_two_attractors(tmp_path):
    scan = scan_of("ssul-set6", {"omega": {"values": [7.375]}})
    arrays = attractors_of(scan, tmp_path)
    assert arrays["attractor_label"].tolist() == [["quasiperiodic", "quasiperiodic"]]
    assert min(arrays["attractor_share"][0]) > 0.2
    assert arrays["attractor_margin"].min() > 2.0
    # their energies of 100,000 periods are 98.291 and 124.738 J
    energies = sorted(arrays["attractor_E1max"][0].tolist())
    assert energies == pytest.approx([98.291, 124.738], rel=0.01)


def test_an_attractor_that_no_start_comes_to_is_carried_on():
    """As if at the second value both orbits had come to T,0."""
    vary = {"P": {"values": [0.5, 0.55, 0.6]}, "v_0": {"values": [0.0, 3.0]}}
    scan = scan_of("impact-oscillator", vary, {"policy": "rest"}, set={"omega": 1.5})
    (block,) = blocks_of(scan)
    arrays = Computer(scan).block(block)
    assert arrays["label"][..., 0].tolist() == [["T,0", "T,1"]] * 3
    for name in ("label", "end_state"):
        arrays[name][1, 1] = arrays[name][1, 0]
    table = AttractorTable(Computer(scan).ends, [(block, arrays)])
    assert table.patched(block, arrays)["attractor"][..., 0].tolist() == [[0, 1], [0, 0], [0, 1]]
    values = {name: array for name, _, array in table.pieces()}
    assert values["attractor_label"].tolist() == [["T,0", "T,1"]] * 3
    assert values["attractor_share"].tolist() == [[0.5, 0.5], [1.0, 0.0], [0.5, 0.5]]
