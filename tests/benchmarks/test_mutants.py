"""The list of mutants fits the sources, and the command tells those that tests do not notice."""

import subprocess
import sys
from pathlib import Path

import pytest

from benchmarks.mutants import MUTANTS, command
from benchmarks.mutants.by_rule import mutants_by_rule
from benchmarks.mutants.mutant import Mutant, StaleError, check
from benchmarks.mutants.trial import KILLED, SURVIVED, BaselineError, Trial

REPO = Path(__file__).resolve().parents[2]
AREA = "return 3.0 * radius * radius"


def test_every_mutant_fits_the_sources():
    check(MUTANTS, REPO)


@pytest.mark.kernels
def test_the_tests_of_every_mutant_exist():
    """Pytest finds each of them, with its case where one is named."""
    names = sorted({test for mutant in MUTANTS for test in mutant.tests})
    options = ["-p", "no:cacheprovider", "-o", "addopts=", "--collect-only", "-q"]
    command_line = [sys.executable, "-m", "pytest", *options, *names]
    found = subprocess.run(command_line, cwd=REPO, capture_output=True, text=True, check=False)
    assert found.returncode == 0, found.stdout
    assert all(mutant.tests for mutant in MUTANTS)


def test_the_list_is_long():
    assert len(MUTANTS) >= 200


def test_names_are_unique_and_all_differ():
    assert len({mutant.name for mutant in MUTANTS}) == len(MUTANTS)
    assert len({(mutant.file, mutant.old, mutant.new) for mutant in MUTANTS}) == len(MUTANTS)


# ---- a checkout of two files ---------------------------------------------------------------------


@pytest.fixture
def checkout(tmp_path):
    """Return a small checkout: a source, and a test that looks at one of its two functions."""
    for name in ("nlds_vines", "benchmarks", "tests", "data", "scans", "docs"):
        (tmp_path / name).mkdir()
    (tmp_path / "pyproject.toml").write_text("")
    source = f"def area(radius):\n    {AREA}\n\n\ndef twice(x):\n    return 2 * x\n"
    (tmp_path / "nlds_vines" / "__init__.py").write_text("")
    (tmp_path / "nlds_vines" / "circle.py").write_text(source)
    test = "from nlds_vines.circle import area\n\ndef test_area():\n    assert area(2.0) == 12.0\n"
    (tmp_path / "tests" / "test_circle.py").write_text(test)
    return tmp_path


def circle(old, new, tests=("tests/test_circle.py::test_area",), name="circle"):
    return Mutant(name, "nlds_vines/circle.py", old, new, tests)


@pytest.mark.slow("copies of the checkout, and a pytest in each")
def test_a_change_that_a_test_notices_is_told_from_one_that_none_does(checkout, tmp_path):
    source = checkout / "nlds_vines" / "circle.py"
    before = source.read_bytes()
    trial = Trial(checkout, tmp_path / "copy")
    seen, unseen = circle("radius * radius", "radius"), circle("return 2 * x", "return x")
    trial.baseline([seen, unseen])
    assert trial.outcome(seen).verdict == KILLED
    found = trial.outcome(unseen)
    assert (found.verdict, found.noticed) == (SURVIVED, False)
    assert "test_area" in found.words
    assert trial.outcome(circle("def area", "def aria")).noticed is False  # no test ran
    assert source.read_bytes() == before
    assert (tmp_path / "copy" / "nlds_vines" / "circle.py").read_bytes() == before


def test_tests_that_fail_without_a_change_tell_nothing(checkout, tmp_path):
    (checkout / "tests" / "test_circle.py").write_text("def test_area():\n    assert False\n")
    with pytest.raises(BaselineError, match="test_area"):
        Trial(checkout, tmp_path / "copy").baseline([circle(AREA, "return 1.0")])


@pytest.mark.parametrize(
    ("old", "words"), [("radius", "stands 3 times"), ("diameter", "stands 0 times")]
)
def test_a_stale_mutant_is_refused(checkout, old, words):
    with pytest.raises(StaleError, match=words):
        check([circle(old, "x")], checkout)
    with pytest.raises(StaleError, match="changes nothing"):
        check([circle(AREA, AREA)], checkout)


# ---- the command ---------------------------------------------------------------------------------


def test_pieces_are_all_of_the_list(capsys):
    assert command.main(["--list"]) == 0
    whole = capsys.readouterr().out.splitlines()
    pieces = []
    for i in (1, 2, 3):
        assert command.main(["--list", "--piece", f"{i}/3"]) == 0
        pieces += capsys.readouterr().out.splitlines()
    assert sorted(pieces) == sorted(whole)
    assert len(whole) == len(MUTANTS)


RULED = """\
def least(values, wide=False):
    \"\"\"Return the least: 1 of 2 < 3.\"\"\"
    if not values or wide and len(values) < 7:
        note(f"{len(values)} ω")
    return min(values) - 2.5
"""


def test_a_source_is_changed_by_rule_where_it_does_something(tmp_path):
    (tmp_path / "a.py").write_text(RULED)
    found = mutants_by_rule("a.py", tmp_path, "tests")
    changed = {line for one in found for line in one.applied_to(RULED).splitlines()}
    assert sorted(changed - set(RULED.splitlines())) == [
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


def test_a_source_is_named_with_its_tests(monkeypatch, checkout, capsys):
    monkeypatch.setattr(command, "CHECKOUT", checkout)
    source = ["--source", "nlds_vines/circle.py"]
    assert command.main([*source, "--tests", "tests", "--list"]) == 0
    assert len(capsys.readouterr().out.splitlines()) == 7
    for wrong in (source, [*source, "--tests", "test"], ["--tests", "tests"]):
        assert command.main(wrong) == 2
        assert len(capsys.readouterr().err.splitlines()) == 1


def test_some_by_name(capsys):
    assert command.main(["--list", "--only", "flight:", "--only", "kernels/watch/touch.py"]) == 0
    assert all(
        "flight:" in line or "touch.py" in line for line in capsys.readouterr().out.splitlines()
    )


@pytest.mark.parametrize(
    "wrong",
    [["--only", "nothing of the kind"], ["--piece", "3/2"], ["--piece", "0/2"], ["--piece"]],
)
def test_a_wrong_request_is_refused_in_one_line(wrong, capsys):
    assert command.main(wrong) == 2
    assert len(capsys.readouterr().err.splitlines()) == 1


@pytest.mark.slow("copies of the checkout, and a pytest in each")
def test_the_exit_status_tells_survivors(monkeypatch, checkout, capsys):
    monkeypatch.setattr(command, "CHECKOUT", checkout)
    seen = circle("radius * radius", "radius", name="seen")
    unseen = circle("return 2 * x", "return x", name="unseen")
    for mutants, status in (((seen,), 0), ((seen, unseen), 1)):
        monkeypatch.setattr(command, "MUTANTS", mutants)
        assert command.main(["--quiet"]) == status
    assert "2 mutants: 1 noticed, 1 not" in capsys.readouterr().out
    monkeypatch.setattr(command, "MUTANTS", (circle("nothing", "x"),))
    assert command.main([]) == 2
