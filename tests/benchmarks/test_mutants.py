"""Mutants by rule: which changes are made, and that those no test notices are named."""

import pytest

from benchmarks import mutants

SOURCE = """\
def least(values, wide=False):
    \"\"\"Return the least: 1 of 2 < 3.\"\"\"
    if not values or wide and len(values) < 7:
        note(f"{len(values)} ω")
    return min(values) - 2.5
"""


def test_a_source_is_changed_where_it_does_something():
    changed = {
        line
        for mutant in mutants.mutants_of(SOURCE, "a.py")
        for line in mutant.applied_to(SOURCE).splitlines()
    }
    assert sorted(changed - set(SOURCE.splitlines())) == [
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


@pytest.fixture
def checkout(tmp_path, monkeypatch):
    """Make a checkout of a source and a test that looks at one of its two functions."""
    for name in ("nlds_vines", "tests"):
        (tmp_path / name).mkdir()
    (tmp_path / "pyproject.toml").write_text("")
    (tmp_path / "nlds_vines" / "__init__.py").write_text("")
    source = "def area(r):\n    return r * r\n\n\ndef twice(x):\n    return 2 * x\n"
    (tmp_path / "nlds_vines" / "circle.py").write_text(source)
    test = "from nlds_vines.circle import area\n\ndef test_area():\n    assert area(3.0) == 9.0\n"
    (tmp_path / "tests" / "test_circle.py").write_text(test)
    monkeypatch.setattr(mutants, "CHECKOUT", tmp_path)
    return tmp_path


CIRCLE = ["nlds_vines/circle.py", "tests/test_circle.py"]


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
    "wrong", [["none.py", "tests"], ["nlds_vines", "none"], ["--piece", "3/2"]]
)
def test_a_wrong_request_is_refused(checkout, wrong, capsys):
    with pytest.raises(SystemExit, match="2"):
        mutants.main(wrong if len(wrong) > 1 and wrong[0][0] != "-" else [*CIRCLE, *wrong])
    assert "error:" in capsys.readouterr().err
