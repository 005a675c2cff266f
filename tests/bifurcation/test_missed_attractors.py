"""Attractors that the sample has missed have numbers as all others have."""

import numpy as np
import pytest
from planes import ALONG, PLANE

import nlds_vines as nv
from nlds_vines.__main__ import main
from nlds_vines.bifurcation import attractor_ends
from nlds_vines.upkeep.rerun import differing

pytestmark = pytest.mark.kernels


@pytest.fixture
def sample_of_one(monkeypatch):
    """Let one orbit of each system be judged before others may stop early."""
    monkeypatch.setattr(attractor_ends, "SAMPLE", 1)
    monkeypatch.setattr(attractor_ends, "LEAST", 1)


def arrays_of(path):
    with nv.read(path) as view:
        return {name: view[name] for name in view.names if name != "status"}


def test_what_one_orbit_has_missed_has_a_number_at_last(sample_of_one, tmp_path, monkeypatch):
    one = arrays_of(nv.scan(PLANE, to=tmp_path / "one.h5", quiet=True))
    monkeypatch.undo()
    all_of = arrays_of(nv.scan(PLANE, to=tmp_path / "all.h5", quiet=True))
    assert sorted(one["attractor_label"].tolist()) == ["T,0", "T,1"]
    assert (one["attractor"] >= 0).all()
    assert (one["arrival"] >= 0).all()
    same = np.array([all_of["attractor_label"].tolist().index(x) for x in one["attractor_label"]])
    assert (same[one["attractor"]] == all_of["attractor"]).all()
    assert np.array_equal(one["label"], all_of["label"])
    assert np.allclose(one["attractor_point"], all_of["attractor_point"][same], atol=1e-9)
    assert np.allclose(one["attractor_E1max"], all_of["attractor_E1max"][same], rtol=1e-9)
    assert one["attractor_share"].tolist() == all_of["attractor_share"][same].tolist()


def test_it_keeps_its_number_along_a_parameter(sample_of_one, tmp_path):
    arrays = arrays_of(nv.scan(ALONG, to=tmp_path / "along.h5", quiet=True))
    labels = arrays["attractor_label"]
    assert (arrays["attractor"] >= 0).all()
    for k in range(labels.shape[1]):
        assert len(set(labels[:, k].tolist()) - {""}) == 1
    assert sorted(set(labels.ravel().tolist())) == ["", "T,0", "T,1"]
    assert labels.shape[1] == 2
    names = labels[np.arange(4)[:, np.newaxis], arrays["attractor"][..., 0]]
    assert np.array_equal(names, arrays["label"][..., 0])


def test_shards_and_resumes_make_the_same_archive(sample_of_one, tmp_path):
    nv.scan(ALONG, to=tmp_path / "whole.h5", quiet=True)
    scan, path = tmp_path / "scan.toml", tmp_path / "parts.h5"
    scan.write_text(nv.load_scan(ALONG).to_toml())
    command = ["bifurcation", str(scan), "-o", str(path), "--quiet"]
    assert main([*command, "--shard", "2/2", "--threads", "1"]) == 0
    assert main([*command, "--shard", "1/2"]) == 0
    assert differing(tmp_path / "whole.h5", path) == []


def test_chaos_that_was_missed_has_a_number(sample_of_one, tmp_path):
    document = {
        **PLANE,
        "system": "ssul-set6",
        "set": {"omega": 7.36},
        "vary": {"v2_0": {"start": -0.5, "stop": 0.5, "num": 12}},
    }
    arrays = arrays_of(nv.scan(document, to=tmp_path / "chaos.h5", quiet=True))
    names = arrays["attractor_label"][arrays["attractor"][..., 0]]
    assert set(arrays["label"].ravel().tolist()) - {"chaos"}
    assert np.array_equal(names, [str(x).split(" to ")[-1] for x in arrays["label"][:, 0]])
    assert np.isfinite(arrays["attractor_E1max"]).all()
