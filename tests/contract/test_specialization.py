"""What is absent from a scene or a record is absent from the machine code, and takes no memory."""

import ast
import json
from importlib import import_module
from pathlib import Path

import numba
import numpy as np
import pytest
from commands import printed

from nlds_vines.bifurcation.request import load_scan
from nlds_vines.bifurcation.run import wanted_of
from nlds_vines.engine.batch import Outputs, records_of
from nlds_vines.kernels.numerics import stored_code
from nlds_vines.model.catalog import load_system

# modules of kernels that only a scene with a wall needs, and only a verdict
CONTACT = {"contact", "impact", "taylor", "touch"}
VARIATIONS = {"variations", "verdict"}

# kernels that must be absent unless the scene has, or the record asks for, the thing named
UNLESS = {
    "a damper": {"scene.damper_in"},
    "a wall": {
        "hertz.hertz_wall_at", "touch.first_touch", "taylor.expand_contact", "exact.touch_in",
    },
    "a limit": {"touch.note_limit", "touch.may_pass", "observe.note_violation"},
    "section": {"observe.note_section"},
    "impacts": {
        "observe.note_touch", "observe.note_depth", "observe.note_release", "impact.greatest_depth",
    },
    "energy": {
        "observe.note_energy", "response.note_peaks", "response.note_energies", "inside.note_end",
        "response.record_breakers", "response.may_set_a_record",
    },
    "response": {"response.tally_piece", "response.tally_push"},
    "clearance": {"exact.note_misses"},
    "tangent": {"flight.propagate"},
}  # fmt: skip

# what the cases of `machine_code.py` have of that, by the exact method
HAS = {
    "none": {"section"},
    "tmd": {"a damper", "section"},
    "ssul": {"a damper", "a wall", "section"},
    "ssul energy": {"a damper", "a wall", "energy"},
    "ssbl": {"a damper", "a wall", "response"},
    "ssvi-b": {"a damper", "a wall", "a limit", "impacts"},
}


@pytest.fixture(scope="module")
def code():
    """Return by case what `machine_code.py` found."""
    program = Path(__file__).with_name("machine_code.py")
    return json.loads(printed(program, NUMBA_DISABLE_JIT="0"))


def modules(case):
    return {name.split(".")[0] for name in case["kernels"]}


@pytest.mark.kernels
def test_loops_without_walls_or_damper_are_others_and_call_no_function(code):
    assert "orbit.orbit" not in code["tmd"]["kernels"]
    assert "flight.step" in code["tmd"]["kernels"]
    assert modules(code["ssul"]) >= CONTACT
    assert "orbit.linear_orbit" not in code["ssul"]["kernels"]
    # the structure alone is compiled without a damper
    assert all("damper" in absent for absent in code["none"]["absent"])
    assert not any("damper" in absent for absent in code["tmd"]["absent"])
    # the loop of a scene without walls is additions and products
    assert code["none"]["loop"] == code["tmd"]["loop"] == []
    for name, case in code.items():  # of all the rest, our own (`kernels.elementary`)
        assert set(case.get("mathematics", ())) <= {"sqrt"}, name
    assert code["ssul"]["loop"] == ["sqrt"]


@pytest.mark.kernels
@pytest.mark.parametrize("case", HAS)
def test_a_case_holds_the_code_of_what_it_has_and_no_other(code, case):
    kernels = set(code[case]["kernels"])
    for thing, names in UNLESS.items():
        expected = names if thing in HAS[case] else set()
        assert kernels & names == expected, thing
    assert not modules(code[case]) & VARIATIONS
    assert bool(modules(code[case]) & CONTACT) == ("a wall" in HAS[case])


def test_the_kernels_asked_for_exist():
    """So that a new name cannot make the test above pass."""
    for name in CONTACT | VARIATIONS | set().union(*UNLESS.values()):
        module, _, function = name.partition(".")
        place = stored_code.modules()[module].relative_to(stored_code.KERNELS).with_suffix("")
        there = import_module(".".join(("nlds_vines.kernels", *place.parts)))
        assert not function or hasattr(there, function), name


@pytest.mark.kernels
@pytest.mark.parametrize(
    ("case", "walls", "limit"),
    [("ssul", ["near"], False), ("ssbl", ["near", "far"], False), ("ssvi-b", ["far"], True)],
)
def test_the_loop_is_compiled_for_the_walls_there_are(code, case, walls, limit):
    loops = code[case]["absent"]
    assert loops
    for absent in loops:
        assert [wall for wall in ("near", "far") if wall not in absent] == walls
        assert ("limit_log" not in absent) == limit
        assert {"energy", "clearance", "tangent", "exact_grid"} <= set(absent)
    assert code[case]["walks"] == [len(walls)]  # towards each wall once


# modules that contacts need, by the law of a case; `contact` if contacts are stepped
LAWS = {
    "ssul": {"contact", "impact", "taylor"},
    "power": {"contact", "taylor"},
    "linear": {"linear_contact"},
    "restitution": {"restitution"},
}


@pytest.mark.kernels
@pytest.mark.parametrize("case", LAWS)
def test_only_the_law_that_a_scene_has_is_in_its_code(code, case):
    kernels = set(code[case]["kernels"])
    if "contact.contact" not in kernels:  # what remains of its module chooses the touched wall
        kernels -= {name for name in kernels if name.startswith("contact.")}
    needed = {name.split(".")[0] for name in kernels}
    assert needed & set().union(*LAWS.values()) == LAWS[case]
    assert ("elementary.power" in code[case]["kernels"]) == (case == "power")


@pytest.mark.kernels
def test_each_method_leaves_the_other_out(code):
    exact, fixed = code["ssul"], code["ssul rk4"]
    assert "fixed_step" not in modules(exact)
    assert not modules(fixed) & {"exact", "touch", "impact"}
    assert {"fixed_step.fly_fixed", "taylor.runge_kutta"} <= set(fixed["kernels"])
    assert {"exact.fly", "impact.short_impact", "taylor.along_series"} <= set(exact["kernels"])
    assert "taylor.runge_kutta" not in exact["kernels"]
    assert not {"taylor.along_series", "taylor.expand_contact"} & set(fixed["kernels"])


# kernels whose answer types decide, which guard nothing but what every law compiles
TOLD_BY_TYPES = {"may_leave", "shrinks"}


def decided(message):
    if isinstance(message, ast.BoolOp):
        return all(map(decided, message.values))
    if isinstance(message, ast.UnaryOp):
        return decided(message.operand)
    if isinstance(message, ast.Call):
        return ast.unparse(message.func) in {"is_a", "says", "same_sort"}
    if isinstance(message, ast.Compare):
        return isinstance(message.ops[0], ast.Is | ast.IsNot)
    return isinstance(message, ast.Constant) and isinstance(message.value, bool)


def told_by_types(text):
    """Return the kernels of a module that tell by types alone whether something is so."""
    names = set()
    functions = [node for node in ast.walk(ast.parse(text)) if isinstance(node, ast.FunctionDef)]
    for function in functions:
        inside = list(ast.walk(function))
        returned = [one.value for one in inside if isinstance(one, ast.Return)]
        asked = [one.test for one in inside if isinstance(one, ast.If | ast.IfExp)]
        does = any(isinstance(one, ast.For | ast.While | ast.Assign) for one in inside)
        is_kernel = "jit" in map(ast.unparse, function.decorator_list)
        if is_kernel and returned and not does and all(map(decided, returned + asked)):
            names.add(function.name)
    return names


def test_what_types_decide_is_asked_where_it_decides():
    """A kernel that returns it hides it: what its caller leaves out is compiled all the same."""
    names = [told_by_types(path.read_text()) for path in stored_code.KERNELS.rglob("*.py")]
    assert set().union(*names) == TOLD_BY_TYPES
    hidden = "@jit\ndef wants(a, b):\n    return a.k is None and not is_a(b, int)"
    assert told_by_types(hidden) == {"wants"}
    assert told_by_types(hidden + " and b.x > 0.0") == set()


@pytest.mark.kernels
def test_no_kernel_asks_at_run_time_whether_a_part_exists_and_floating_point_is_strict(code):
    undecided = {name: case["undecided"] for name, case in code.items() if "undecided" in case}
    assert undecided == {name: [] for name in undecided}
    contracts = {name: case["contracts"] for name, case in code.items()}
    assert contracts.pop("loose")  # what is compiled otherwise is told from the kernels
    assert contracts == {name: [] for name in contracts}


JUDGED = {"section", "ends", "evidence"}
LIMITED = {"kind": "ssvi-b", **load_system("ssbl").parameters}


@pytest.mark.parametrize(
    ("system", "want", "expected"),
    [
        ("ssul-set6", ["energy"], {"energy"}),
        ("ssul-set6", ["peak"], {"peak"}),
        ("ssul-set6", ["clearance"], {"clearance"}),
        ("ssul-set6", ["section"], {"section"}),
        ("tmd", ["section"], {"section"}),
        ("ssul-set6", ["impacts"], {"counts", "cycle"}),
        ("tmd", ["regime"], JUDGED),
        ("ssul-set6", ["lyapunov"], JUDGED | {"counts"}),
        ("ssbl", ["energy"], {"energy"}),
        (LIMITED, ["energy"], {"energy", "violation"}),  # a limit is always reported
    ],
)
def test_nothing_is_allocated_that_was_not_asked_for(system, want, expected):
    scan = load_scan({"system": system, "vary": {"omega": [6.0]}, "record": {"want": want}})
    outputs = Outputs.of(wanted_of(scan), (2, 3), scan.transient, scan.periods)
    buffers = {**outputs.buffers._asdict(), "evidence": outputs.evidence, "status": outputs.status}
    allocated = {name for name, buffer in buffers.items() if buffer is not None}
    assert allocated == expected | {"status"}


def test_cells_that_cannot_be_written_to_take_the_same_machine_code():
    """As a scan has them: for Numba, such an array is of another type."""
    scan = load_scan({"system": "ssul-set6", "vary": {"omega": [6.0, 7.5]}})
    cells = scan.cells()[:, np.newaxis]
    assert not cells.flags.writeable
    usual = records_of(np.zeros_like(cells))
    assert numba.typeof(cells.view(np.recarray)) != numba.typeof(usual)
    assert numba.typeof(records_of(cells)) == numba.typeof(usual)
    assert np.array_equal(records_of(cells), cells)
