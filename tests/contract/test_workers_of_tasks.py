"""Response curves and loads in time by workers and in shards: the same archives as by one run."""

import multiprocessing
from concurrent.futures import ProcessPoolExecutor

import pytest

import nlds_vines as nv
from nlds_vines.loads import datasets
from nlds_vines.upkeep.rerun import differing

CURVES = "response-curves --system tmd --vary omega=5:7:9 --set P=300"
BLOWS = "response-history --system none --system tmd --vary impulse=100:500:5 --duration 2"
HISTORIES = "response-history --system none --system tmd --impulse 300 --duration 2"

pytestmark = pytest.mark.kernels


@pytest.mark.parametrize("asked", [CURVES, BLOWS, HISTORIES])
def test_shards_end_in_the_archive_of_one_run(asked, here, answer, monkeypatch):
    monkeypatch.setattr(datasets, "BLOCK", 2)
    words = asked.split()
    answer(*words, "--quiet", "-o", "whole.h5")
    first = answer(*words, "-o", "a.h5", "--shard", "1/2")
    assert "shard 1/2: " in first
    assert "the last shard to end writes the archive" in first
    assert not (here / "a.h5").exists()
    last = answer(*words, "-o", "a.h5", "--shard", "2/2")
    assert "a.h5" in last
    assert differing(here / "whole.h5", here / "a.h5") == []
    assert "shard 2/2: " in answer(*words, "-o", "b.h5", "--shard", "2/2", "--dry-run")


def test_a_shard_draws_no_picture(refusal):
    for asked in (CURVES, HISTORIES):
        words = refusal(*asked.split(), "-o", "a.h5", "--shard", "1/2", "--plot", "a.png")
        assert "a shard draws nothing" in words


def test_processes_compute_curves_and_blows(here, monkeypatch):
    monkeypatch.setattr(datasets, "BLOCK", 2)
    vary = {"impulse": {"start": 100.0, "stop": 500.0, "num": 5}}
    along = {"omega": [5.0, 6.0, 7.0]}
    with ProcessPoolExecutor(2, multiprocessing.get_context("spawn")) as pool:
        for how in ({"to": "one"}, {"to": "two", "executor": pool}):
            to = how.pop("to")
            blows = {"vary": vary, "duration": 2.0, "to": f"{to}-blows.h5"}
            nv.response_history(["none", "tmd"], **blows, **how, quiet=True)
            nv.response_curves(["tmd"], vary=along, to=f"{to}-curves.h5", **how, quiet=True)
    assert differing(here / "one-blows.h5", here / "two-blows.h5") == []
    assert differing(here / "one-curves.h5", here / "two-curves.h5") == []
