"""What is absent from a scene or a record is absent from the machine code, and takes no memory."""

import json
import os
import subprocess
import sys
from dataclasses import fields
from pathlib import Path

import pytest

import nlds_vines
from nlds_vines.block import Outputs
from nlds_vines.scan import load_scan

CONTACT = {"contact", "contact_field", "impact", "runge_kutta", "touch"}
"""Modules of kernels that only a scene with a wall needs."""


@pytest.fixture(scope="module")
def code(tmp_path_factory):
    """Return by case what `machine_code.py` found; compiled afresh, as a cache hides the code."""
    done = subprocess.run(
        [sys.executable, str(Path(__file__).with_name("machine_code.py"))],
        capture_output=True,
        text=True,
        check=False,
        env={
            **os.environ,
            "PYTHONPATH": str(Path(nlds_vines.__path__[0]).parent),
            "NUMBA_CACHE_DIR": str(tmp_path_factory.mktemp("cache")),
            "NUMBA_DISABLE_JIT": "0",
        },
    )
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


def modules(case):
    return {name.split(".")[0] for name in case["kernels"]}


def of_module(case, *names):
    return {name for name in case["kernels"] if name.split(".")[0] in names}


def test_a_scene_without_walls_holds_no_contact_code(code):
    assert not modules(code["tmd"]) & CONTACT
    assert "orbit.orbit" not in code["tmd"]["kernels"]
    assert "flight.step" in code["tmd"]["kernels"]
    # ... and a scene with walls does, so that this can fail
    assert modules(code["ssul"]) >= CONTACT
    assert "orbit.linear_orbit" not in code["ssul"]["kernels"]


def test_the_loop_of_a_scene_without_walls_is_additions_and_products(code):
    assert code["tmd"]["loop"] == []
    assert "pow" not in code["tmd"]["mathematics"]
    assert {"pow", "sqrt"} <= set(code["ssul"]["loop"])


def test_what_is_not_recorded_is_not_compiled(code):
    observed = of_module(code["ssul"], "observe", "peaks")
    assert observed == {"observe.note_section"}
    energy = of_module(code["ssul energy"], "observe", "peaks")
    assert {"observe.note_energy", "observe.note_step"} <= energy
    assert of_module(code["ssul energy"], "peaks")
    assert "observe.note_section" not in energy


def test_each_method_leaves_the_other_out(code):
    exact, fixed = code["ssul"], code["ssul rk4"]
    assert not of_module(exact, "fixed_step")
    assert not of_module(fixed, "exact", "touch", "impact")
    assert {"fixed_step.fly_fixed", "runge_kutta.fourth"} <= set(fixed["kernels"])
    assert {"exact.fly", "impact.short_impact", "runge_kutta.eighth"} <= set(exact["kernels"])
    assert "runge_kutta.fourth" not in exact["kernels"]
    assert "runge_kutta.eighth" not in fixed["kernels"]


def test_no_kernel_asks_at_run_time_whether_a_part_exists(code):
    found = {name: case["undecided"] for name, case in code.items() if "undecided" in case}
    assert found == {name: [] for name in found}


def test_floating_point_is_strict(code):
    found = {name: case["contracts"] for name, case in code.items()}
    assert found.pop("loose")  # what is compiled otherwise is told from the kernels
    assert found == {name: [] for name in found}


def allocated(system, *want):
    """Return the names of the buffers that a scan of this request has."""
    scan = load_scan(None, {"system": system, "record": {"want": list(want)}})
    outputs = Outputs.of(scan, (2, 3), scan.transient, scan.periods)
    buffers = {field.name: getattr(outputs, field.name) for field in fields(outputs)}
    return {name for name, buffer in buffers.items() if buffer is not None}


def test_nothing_is_allocated_that_was_not_asked_for():
    assert allocated("ssul-set6", "energy") == {"energy", "status"}
    assert allocated("ssul-set6", "clearance") == {"clearance", "status"}
    assert allocated("tmd", "section") == {"section", "status"}
    assert allocated("ssul-set6", "section") == {"section", "status"}
    judged = {"section", "cycle", "ends", "evidence", "status"}
    assert allocated("tmd", "regime") == judged
    assert allocated("ssul-set6", "settling") == judged | {"counts"}
    assert allocated("ssul-set6", "peak") == {"peak", "status"}
    assert allocated("ssul-set6", "impacts") == {"counts", "cycle", "status"}
