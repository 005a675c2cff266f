"""Benchmarks: solvers compared, extremes within bounds, sizes counted, mutants by rule."""

import ast
import math
from importlib import import_module
from importlib.util import find_spec
from unittest.mock import Mock

import numpy as np
import pytest
from support import REPO

from benchmarks import accuracy, extremes, hosts, house, mutants, sinks
from benchmarks.accuracy import SOLVERS, Point, cost, points_of
from benchmarks.extremes import EXTREMES
from nlds_vines import load_system, simulate

# ---- accuracy: others converge to the true state, and the cost of an error is interpolated -------


INSTALLED = [solver for solver in SOLVERS if find_spec(solver.package)]


@pytest.fixture(scope="module")
def cases():
    return {case.name: case for case in accuracy.cases()}


@pytest.mark.kernels
def test_the_truth_of_each_case_is_that_of_the_finest_settings(cases):
    assert list(cases) == ["ssul-set6", "steel", "ssbl", "near-grazing", "tmd"]
    for case in cases.values():
        fine = {"method": "rk4", "period_steps": 8192}
        orbit = simulate(case.system, 20, start=case.start, record=(), **fine)
        assert np.abs(orbit.state - case.truth).max() < 1e-11, case.name


@pytest.mark.kernels
@pytest.mark.parametrize("solver", INSTALLED, ids=lambda solver: solver.name)
def test_a_solver_converges_to_the_truth(solver, cases, monkeypatch):
    monkeypatch.setattr(accuracy, "seconds_of", lambda follow: 1.0)
    for name in ("ssul-set6", "ssbl"):
        errors = [point.error for point in points_of(cases[name], solver)]
        assert errors[-1] < 3e-8
        assert errors[-1] < errors[0] / 10


def test_scipy_is_split_where_contacts_begin():
    system = load_system("ssul-set6", omega=6.28)
    section, touches = accuracy.scipy_orbit(system, accuracy.rest_state(system), 1e-10, 3)
    orbit = simulate(system, 3, record=("section", "impacts"))
    assert len(touches) == len(orbit.impacts) > 0
    np.testing.assert_allclose(touches, orbit.impacts["touch"], rtol=1e-8)
    np.testing.assert_allclose(section, orbit.section, atol=1e-8)


@pytest.mark.kernels
@pytest.mark.parametrize("name", hosts.PROGRAMS)
def test_programs_follow_a_frame_through_an_impact(name):
    make, package, _ = hosts.PROGRAMS[name]
    pytest.importorskip(package)
    system = hosts.frame_of(3, hosts.NEAR)
    state = simulate(system, 1, transient=40, quiet=True).state
    start = state.reshape(-1, 2).T.ravel()
    truth = hosts.ours(system, start)(hosts.FINEST, 2)
    error = np.abs(make(system, start)(1e-10, 2) - truth).max()
    assert error < 1e-7 * np.abs(state).max()


@pytest.mark.kernels
@pytest.mark.parametrize("name", sinks.PROGRAMS)
@pytest.mark.parametrize("title", ["cubic, 1:1", "cubic between rigid walls"])
def test_programs_follow_a_sink(name, title):
    make, package, _, _ = sinks.PROGRAMS[name]
    pytest.importorskip(package)
    system = sinks.systems()[title]
    start = simulate(system, 1, transient=40, quiet=True).state.reshape(-1, 2).T.ravel()
    follow = make(system, start, 1e-10)
    if follow is None:
        assert system.dampers[0].walls
        return
    truth = sinks.Equation(system).twin().follow(start, 2).sections[-1]
    assert np.abs(follow(2) - truth).max() < 1e-7 * np.abs(start).max()


def test_a_cost_is_interpolated_along_the_cheapest_settings():
    pairs = (1e-2, 1e-6), (1e-6, 1e-4), (1e-5, 1e-3), (math.inf, math.inf)
    curve = [Point(SOLVERS[0], 0.0, error, seconds) for error, seconds in pairs]
    assert cost(curve, 1e-4) == pytest.approx(1e-5)
    assert cost(curve, 1e-1) == pytest.approx(1e-6)  # the cheapest is better than asked for
    assert cost(curve, 1e-7) == math.inf


def test_a_solver_that_fails_has_an_infinite_error(cases):
    follow = Mock(side_effect=ArithmeticError("step too small"))
    solver = SOLVERS[0]._replace(prepare=lambda system, start: follow, settings=(1.0,))
    (point,) = points_of(cases["tmd"], solver)
    assert point.error == point.seconds == math.inf


# ---- extremes: within their bounds, which a fault exceeds ----------------------------------------


real_load, real_system = extremes.load_system, extremes.Preset
linear, split, steady = extremes.linear_sections, extremes.scipy_orbit, extremes.steady_state
FAULTS = {
    "stiff": ("DURATION", extremes.DURATION * (1 + 1e-9)),
    "soft": ("linear_sections", lambda *how: linear(*how) * (1 + 1e-9)),
    "grazing": ("steady_state", lambda system: extremes.rest_state(system)),
    "undamped": ("energy_of", lambda system, states: states[:, 1] ** 2),
    "mass ratio": ("scipy_orbit", lambda system, *how: split(system.with_(c1=451.0), *how)),
    "slow": ("steady_state", lambda system: extremes.rest_state(system)),
    "fast": ("steady_state", lambda system: steady(system) * (1 + 1e-5)),
    "e = 0 and 1": ("Preset", lambda kind, p, law: real_system(kind, {**p, "e": 0.5}, law=law)),
    "overflow": ("is_refused", lambda *how, **options: False),
    "tiny states": ("load_system", lambda name, P: real_load(name, P=max(P, 1e-60))),
}


@pytest.mark.kernels
@pytest.mark.parametrize("extreme", EXTREMES, ids=lambda extreme: extreme.name)
def test_an_extreme_stays_within_its_bound_and_a_fault_exceeds_it(extreme, monkeypatch):
    assert extreme.measure() <= extreme.bound
    monkeypatch.setattr(extremes, *FAULTS[extreme.name])
    assert not extreme.measure() <= extreme.bound


@pytest.mark.kernels
def test_a_bound_that_is_exceeded_is_named(monkeypatch, tmp_path, capsys):
    page = tmp_path / "page.md"
    page.write_text("above\n<!-- python -m benchmarks.extremes -->\nold\n<!-- end -->\nbelow\n")
    monkeypatch.setattr("sys.argv", ["extremes", "--page", str(page)])
    for value, status in ((0.5, 0), (math.nan, 1)):
        extreme = extremes.Extreme("number", lambda value=value: value, 1.0)
        monkeypatch.setattr(extremes, "EXTREMES", (extreme,))
        assert extremes.main() == status
        printed, text = capsys.readouterr().out, page.read_text()
        assert ("| broken |" in printed) == bool(status)
        assert printed in text
        assert "old" not in text
        assert text.startswith("above\n")
        assert text.endswith("<!-- end -->\nbelow\n")


# ---- house: the counts of sources whose counts are plain to see ----------------------------------


SOURCE = '''"""A docstring
of two lines."""

LIMIT = 1
"""The limit."""


def double(given):
    """Twice as much."""
    low, high = given, -given  # folded
    parts = [low for _ in range(2)]
    text = f"{low} of {LIMIT}"
    return (
        high if parts else text
    )
'''


def test_the_counts_of_a_source(tmp_path):
    path = tmp_path / "source.py"
    path.write_text(SOURCE)
    assert house.counts_of([path]) == {
        "files": 1,
        "lines": 15,
        "statements": 9,  # three docstrings, one constant, one function, four statements in it
        "functions": 1,
        "tokens": 3 + 6 + 8 + 12 + 3 + 8,  # an f-string is one
        "lines of docstrings": 4,
        "a, b = x, y": 1,
        "x if c else y": 1,
        "comprehensions": 1,
    }


def write_all(folder, names, text):
    for name in names.split():
        path = folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)


def test_what_is_counted_where(tmp_path):
    modules = "nlds_vines/kernels/a.py nlds_vines/kernels_too.py tests/b.py benchmarks/c.py"
    write_all(tmp_path, modules, "x = 1\n")
    counts = {
        name: house.counts_of(paths)["files"] for name, paths in house.areas(tmp_path).items()
    }
    assert counts == {"package without kernels": 1, "kernels": 1, "tests": 1, "benchmarks": 1}
    write_all(tmp_path / "nlds_vines", "model/host.py model/loads/noise.py tasks/basins.py", "")
    parts = house.parts(tmp_path / "nlds_vines")
    assert {name: len(paths) for name, paths in parts.items()} == {
        "kernels/a.py": 1,
        "kernels_too.py": 1,
        "model": 2,
        "tasks/basins.py": 1,
    }
    write_all(tmp_path / "nlds_vines", "tests/a.py loads/test/b.py", "")
    assert len(house.sources_of(tmp_path / "nlds_vines")) == 5


ASKS = """
from a import General

def draw(system: General, is_host=False) -> General:
    if system.has_hosts or isinstance(system, General):
        return draw(system, is_host=True)
"""


def test_words_that_ask_what_a_system_is(tmp_path):
    """Neither imports nor annotations ask; the engine and presets may."""
    write_all(tmp_path, "pictures/drawing.py engine/orbit.py model/presets.py", ASKS)
    places = house.asking_words(tmp_path)
    assert places == {"pictures.drawing": {"is_host": 2, "has_hosts": 1, "General": 1}}


def test_names_of_several_modules(tmp_path):
    write_all(tmp_path, "a.py b.py", "class Load:\n    def draw(self): 1\ndef fly(): 1\n")
    write_all(tmp_path, "c.py", "def fly(): 1\ndef draw(): 1\n")
    assert house.names_defined_twice(tmp_path, ast.ClassDef) == {"Load": ["a", "b"]}
    assert house.names_defined_twice(tmp_path, ast.FunctionDef) == {"fly": ["a", "b", "c"]}


CALLED = """
import threading

def wrapped(function): return function

@wrapped
def in_thread(): return [1 for _ in "ab"]

class Law:
    def never(self): return 2

def start():
    def inner(): return (lambda: 3)()
    thread = threading.Thread(target=in_thread)
    thread.start()
    thread.join()
    return inner()
"""


def test_functions_that_a_call_executes(tmp_path, monkeypatch):
    write_all(tmp_path, "toy_of_trunk/called.py", CALLED)
    monkeypatch.syspath_prepend(tmp_path)

    def call():
        import_module("toy_of_trunk.called").start()

    places = house.executed(tmp_path / "toy_of_trunk", call)
    path = tmp_path / "toy_of_trunk" / "called.py"
    names = {name for name, _ in places[path]}
    assert names == {"wrapped", "in_thread", "start", "inner"}
    wrapped, in_thread, start = 8, 15, 42
    assert house.function_counts(path, places[path]) == (4, wrapped + in_thread + start)


@pytest.mark.long
def test_the_trunk_reaches_from_the_command_into_kernels_and_the_picture():
    places = house.run_trunk(REPO)
    kernels = REPO / "nlds_vines" / "kernels"
    assert REPO / "nlds_vines" / "__main__.py" in places
    assert any(kernels in path.parents for path in places)
    assert any(path.name == "diagram.py" for path in places)


# ---- mutants by rule: which changes are made, and that those no test notices are named -----------


CHANGED = """\
def least(values, wide=False):
    \"\"\"Return the least: 1 of 2 < 3.\"\"\"
    if not values or wide and len(values) < 7:
        note(f"{len(values)} ω")
    return min(values) - 2.5
"""


def test_a_source_is_changed_where_it_does_something():
    texts = [mutant.applied_to(CHANGED) for mutant in mutants.mutants_of(CHANGED, "a.py")]
    changed = {line for text in texts for line in text.splitlines()}
    assert sorted(changed - set(CHANGED.splitlines())) == [
        "        pass",
        "    if (not values and (wide and len(values) < 7)):",
        "    if (values) or wide and len(values) < 7:",
        "    if not values or (wide or len(values) < 7):",
        "    if not values or wide and (len(values) <= 7):",
        "    if not values or wide and len(values) < 8:",
        "    return (min(values) + 2.5)",
        "    return None",
        "    return min(values) - 3.5",
        "def least(values, wide=True):",
    ]


CIRCLE = ["nlds_vines/circle.py", "tests/test_circle.py"]


@pytest.fixture
def checkout(tmp_path, monkeypatch):
    """Make a checkout of a source and a test that looks at one of its two functions."""
    write_all(tmp_path, "pyproject.toml nlds_vines/__init__.py", "")
    source = "def area(r):\n    return r * r\n\n\ndef twice(x):\n    return 2 * x\n"
    write_all(tmp_path, CIRCLE[0], source)
    test = "from nlds_vines.circle import area\n\ndef test_area():\n    assert area(3.0) == 9.0\n"
    write_all(tmp_path, CIRCLE[1], test)
    monkeypatch.setattr(mutants, "CHECKOUT", tmp_path)
    return tmp_path


@pytest.mark.slow("copies of the checkout, and a pytest in each")
def test_those_that_no_test_notices_are_named(checkout, capsys):
    before = (checkout / CIRCLE[0]).read_bytes()
    assert mutants.main(CIRCLE) == 1
    survivors = capsys.readouterr().out.splitlines()
    assert [line.split(": ", 2)[2] for line in survivors[:-1]] == [
        "return None for return 2 * x",
        "(2 / x) for 2 * x",
        "3 for 2",
    ]
    assert survivors[-1].startswith("5 mutants: 2 noticed, 3 not")
    assert (checkout / CIRCLE[0]).read_bytes() == before


def test_tests_that_fail_without_a_change_are_refused(checkout, capsys):
    (checkout / "tests" / "test_circle.py").write_text("def test_area():\n    assert False\n")
    assert mutants.main(CIRCLE) == 2
    assert "test_area" in capsys.readouterr().err


def test_pieces_are_the_whole(checkout, capsys):
    lists = []
    for piece in ("1/1", "1/2", "2/2"):
        assert mutants.main([*CIRCLE, "--list", "--piece", piece]) == 0
        lists.append(capsys.readouterr().out.splitlines())
    assert len(lists[0]) == 5
    assert sorted(lists[0]) == sorted(lists[1] + lists[2])


@pytest.mark.parametrize(
    "words", [["none.py", "tests"], ["nlds_vines", "none"], [*CIRCLE, "--piece", "3/2"]]
)
def test_a_wrong_request_is_refused(checkout, words, capsys):
    with pytest.raises(SystemExit, match="2"):
        mutants.main(words)
    assert "error:" in capsys.readouterr().err
