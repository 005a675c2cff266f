"""The long versions of the tests of archives, run by name:

    python -m pytest tests/contract/endurance.py

105 runs of all tasks killed at random moments, a cut at every file operation of a run and at every
system call (with strace), a million cells in one archive.  Some twenty minutes on two processors.
"""

import os
import shutil
import subprocess
import sys
import time

import numpy as np
import pytest
import xarray as xr
from test_resumed_after_kill import FORKS, TASKS, kill_and_resume, replay, run_to

import nlds_vines as nv

FEW_BLOCKS = ("portrait", "transients", "response-curves")
"""Tasks that are one or two blocks here, so that few moments find one saved."""


@pytest.mark.parametrize("task", TASKS)
def test_fifteen_runs_of_each_task_killed_at_random_moments(task, tmp_path):
    assert kill_and_resume(task, 15, tmp_path) > 0 or task in FEW_BLOCKS


@FORKS
def test_a_run_cut_between_all_file_operations_can_be_resumed(tmp_path):
    assert replay(tmp_path, stride=1) > 150


def test_a_million_cells_in_one_archive_open_lazily(tmp_path):
    omega = {"start": 5.0, "stop": 8.0, "num": 1000}
    force = {"start": 600.0, "stop": 1000.0, "num": 1000}
    document = {
        "system": "none",
        "vary": {"omega": omega, "P": force},
        "sampling": {"transient": 1, "periods": 1},
        "record": {"want": ["section", "energy"]},
    }
    began = time.perf_counter()
    path = nv.scan(document, to=tmp_path / "million.h5")
    took = time.perf_counter() - began
    began = time.perf_counter()
    with xr.open_dataset(path, engine="h5netcdf", chunks=None) as dataset:
        assert dataset.sizes["omega"] * dataset.sizes["P"] == 10**6
        row = dataset["E1max"].isel(omega=500, start=0).values
    opened = time.perf_counter() - began
    print(f"computed in {took:.1f} s; {path.stat().st_size / 1e6:.0f} MB; a row in {opened:.2f} s")
    assert np.isfinite(row).all()
    assert opened < took  # a row, not the whole archive


PROGRAM = """
import sys
from pathlib import Path
sys.path.insert(0, {tests!r})
from test_resumed_after_kill import run_to
run_to(Path({path!r}))
"""


def traced(path, *options):
    """Run a scan under strace; return the exit status and the calls it made, one line each."""
    log = path.parent.parent / "calls.log"
    program = PROGRAM.format(tests=os.path.dirname(__file__), path=str(path))
    run = subprocess.run(
        ["strace", "-qq", "-o", str(log), *options, sys.executable, "-c", program],
        env={**os.environ, "PYTHONPATH": os.pathsep.join(sys.path), "OMP_NUM_THREADS": "1"},
        stderr=subprocess.DEVNULL,
        check=False,
    )
    return run.returncode, log.read_text().splitlines()


@pytest.mark.skipif(shutil.which("strace") is None, reason="strace is not installed")
def test_a_run_killed_at_every_system_call_that_changes_a_file_can_be_resumed(tmp_path):
    """Unlike the cuts above, these lie inside HDF5 as well."""
    reference = run_to(tmp_path / "reference.h5")
    path = tmp_path / "cut" / "scan.h5"
    cuts = 0
    for name in ("write", "pwrite64", "fsync", "ftruncate", "fallocate", "rename", "unlink"):
        for count in range(1, 10_000):
            path.parent.mkdir()
            inject = ("-e", f"trace={name}", "-e", f"inject={name}:signal=KILL:when={count}")
            status, calls = traced(path, *inject)
            assert run_to(path) == reference, (name, count)
            shutil.rmtree(path.parent)
            if status == 0:
                break
            cuts += 1
            assert calls
    assert cuts > 50
