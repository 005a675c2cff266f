"""The time that --dry-run estimates: of a sample of the orbits of the scan as they are."""

import numpy as np
import pytest

from nlds_vines.bifurcation import estimate as module
from nlds_vines.bifurcation.compute import Computer
from nlds_vines.bifurcation.estimate import estimate
from nlds_vines.bifurcation.request_file import load_scan
from nlds_vines.runs.threads import threads_in_use

OMEGA = {"omega": {"start": 6.0, "stop": 7.0, "num": 400}}


def scan_of(**more):
    tables = {"system": "none", "vary": OMEGA, "sampling": {"transient": 30, "periods": 20}}
    return load_scan({**tables, "record": {"want": ["energy"]}, **more})


@pytest.fixture
def clock(monkeypatch):
    """Let an orbit take a millisecond for 50 periods, and 2 ms beyond 6.5 rad/s; note the calls."""
    calls, now = [], [0.0]

    def lanes(self, chains, starts, places):
        periods = self.scan.transient + self.scan.periods
        each = np.where(chains["omega"][:, 0] > 6.5, 2e-3, 1e-3)
        now[0] += float(each.sum()) * periods / 50
        calls.append((len(chains), periods, threads_in_use(), starts))
        return {}

    monkeypatch.setattr(Computer, "lanes", lanes)
    monkeypatch.setattr(module.time, "perf_counter", lambda: now[0])
    return calls


def test_a_scan_that_fits_is_run_whole_and_so_known(clock):
    assert estimate(scan_of()).seconds == pytest.approx(0.6)
    assert sum(count for count, *_ in clock) == 400 + 1  # one compiles


def test_a_sample_stands_for_all_cells(clock, monkeypatch):
    monkeypatch.setattr(module, "SECONDS", 0.15)
    assert estimate(scan_of()).seconds == pytest.approx(0.6, rel=0.2)
    assert sum(count for count, *_ in clock) < 300


def test_many_starts_are_many_orbits_and_begin_where_they_do(clock):
    random = {"policy": "random", "count": 5}
    assert estimate(scan_of(start=random)).seconds == pytest.approx(3.0, rel=0.1)
    assert np.abs(clock[-1][3]).min() > 0


def test_a_long_orbit_is_cut_and_drawn_out(clock, monkeypatch):
    monkeypatch.setattr(module, "MOST_PERIODS", 500)
    sampling = {"transient": 30_000, "periods": 20_000}
    assert estimate(scan_of(sampling=sampling)).seconds == pytest.approx(600.0, rel=0.1)
    assert {periods for _, periods, *_ in clock} == {500}


def test_a_sweep_uses_no_more_threads_than_it_has_chains(clock):
    before = threads_in_use()
    found = estimate(scan_of(start={"policy": "up"}))
    assert {threads for _, _, threads, _ in clock[1:]} == {1}
    assert threads_in_use() == found.threads == before
