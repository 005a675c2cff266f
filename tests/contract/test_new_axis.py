"""A new axis is an entry, a new start two lines: made here in a copy, by a diff."""

import json

import commands
import numpy as np
import pytest
from scipy.linalg import expm
from support import linear_flow

import nlds_vines as nv

PROGRAM = """
import json
from pathlib import Path
import nlds_vines as nv
from nlds_vines.__main__ import main
from nlds_vines.archives.archive import read
scan = ["bifurcation", "--system", "tmd", "--start", "deflected", "--quiet", "--transient", "0",
        "--periods", "2", "--record", "section", "--vary", "stiffness_ratio=0.01:0.02:3"]
assert main([*scan, "-o", "new.h5", "--plot", "new.png"]) == 0
assert main(["rerun", "new.h5", "-o", "again.h5", "--quiet"]) == 0
with read("new.h5") as view:
    k2, start, section = (view[name].tolist() for name in ("k2", "start", "section"))
print(json.dumps([k2, start, section, nv.open_archive("new.h5").request.to_toml()]))
"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return commands.changed(tmp_path_factory.mktemp("changed"), "axis_and_start")


def test_scans_know_both(folder):
    where = {"PYTHONPATH": str(folder), "NUMBA_DISABLE_JIT": "1"}
    text = commands.printed("-c", PROGRAM, cwd=folder, **where)
    k2, start, section, toml = json.loads(text.splitlines()[-1])
    p = nv.load_system("tmd").parameters
    np.testing.assert_allclose(k2, np.linspace(0.01, 0.02, 3) * p["k1"], rtol=1e-15)
    assert start == ["deflected"]
    assert 'policy = "deflected"' in toml
    for value, states in zip(k2, section, strict=True):
        flow = expm(linear_flow({**p, "k2": value}) * 2 * np.pi / p["omega"])
        state = flow @ [p["P"] / p["k1"], 0.0, 0.0, 0.0, 1.0, 0.0]  # the last two: cos, sin
        after = [state[:4], (flow @ state)[:4]]
        np.testing.assert_allclose(states[0], after, rtol=0, atol=1e-13)


def test_its_unit_may_vary_beside_it(folder):
    axes = ("--vary", "stiffness_ratio=0.01:0.02:3", "--vary", "k1=3e4:4e4:3", "--dry-run")
    command = ("-m", "nlds_vines", "bifurcation", "--system", "tmd", *axes)
    text = commands.printed(*command, cwd=folder, PYTHONPATH=str(folder))
    assert "k₂/k₁, k₁" in text
    assert "k2 =" not in text
