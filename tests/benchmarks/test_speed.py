"""Comparison with an earlier state: its checkout, pairs of times, their ratios, the table."""

from contextlib import contextmanager
from types import SimpleNamespace

import numba
import numpy as np
import pytest
from support import REPO

import nlds_vines
from benchmarks import cases, cold, speed
from benchmarks.speed import Times

# ---- an earlier state ----------------------------------------------------------------------------


@pytest.fixture
def repository(tmp_path, monkeypatch):
    """A repository with two commits, whose checkouts lie beside it."""
    folder = tmp_path / "repository"
    (folder / "nlds_vines").mkdir(parents=True)
    monkeypatch.setattr(speed, "HERE", folder)
    monkeypatch.setattr(speed.tempfile, "tempdir", str(tmp_path))
    speed.git("init", "-q")
    for number in (1, 2):
        (folder / "nlds_vines" / "__init__.py").write_text(f"number = {number}\n")
        speed.git("add", ".")
        who = "-c", "user.name=a", "-c", "user.email=a@b"
        speed.git(*who, "commit", "-q", "-m", f"number {number}")
    return folder


def test_a_commit_is_checked_out_once(repository):
    (repository / "nlds_vines" / "__init__.py").write_text("number = 3\n")
    folder = speed.folder_of("HEAD~1")
    source = folder / "nlds_vines" / "__init__.py"
    assert source.read_text() == "number = 1\n"
    (folder / "kernels").mkdir()
    assert speed.folder_of("HEAD~1") == folder
    assert (folder / "kernels").exists()  # so that they are compiled once
    assert [path.name for path in folder.parent.iterdir()] == [folder.name]


def test_a_folder_may_stand_in_place_of_a_commit(repository):
    assert speed.folder_of(str(repository)) == repository


def test_what_is_no_commit_is_refused(repository):
    with pytest.raises(SystemExit, match="Needed a single revision"):
        speed.folder_of("nothing")


# ---- names, and what is compared -----------------------------------------------------------------


def test_the_newest_name_that_a_package_has_is_called(monkeypatch):
    monkeypatch.setitem(cases.NAMES, "scan", ("System.compute", "compute", "scan"))
    assert cases.public("scan") is nlds_vines.scan
    monkeypatch.setitem(cases.NAMES, "scan", ("compute",))
    with pytest.raises(SystemExit, match="scan: this package has none of the names compute"):
        cases.public("scan")


@pytest.mark.parametrize("work", cases.NAMES)
def test_this_package_has_every_name(work):
    assert callable(cases.public(work))


def test_orbits_that_repeat_to_the_bit_are_told(monkeypatch):
    section = np.arange(24.0).reshape(3, 4, 2)  # starts, periods, components

    @contextmanager
    def read():
        yield archive

    result = SimpleNamespace(read=read)
    archive = {"section": section}
    assert cases.repeating(result) == ""
    section[1, 3] = section[1, 1]
    assert cases.repeating(result) == "1 of 3 orbits repeat"
    archive = {"E1max": section}
    assert cases.repeating(result) == ""


def test_only_the_calls_of_kernels_count():
    @numba.njit
    def kernel(n):
        total = 0.0
        for k in range(n):
            total += k**0.5
        return total

    kernel(1)
    call = type(kernel).__call__
    with cases.in_kernels() as times:
        seconds = cases.spent(lambda: kernel(3_000_000))
        cases.spent(lambda: sum(range(100_000)))
    assert len(times) == 1
    assert 0.0 < times[0] <= seconds
    assert type(kernel).__call__ is call
    kernel(1)
    assert len(times) == 1


# ---- pairs of times ------------------------------------------------------------------------------


def test_both_states_work_in_turn():
    order = []

    def spends(side):
        def work(name):
            order.append(side)
            return {name: Times(float(len(order)), 0.0)}

        return work

    rows = speed.in_turn(spends("ours"), spends("other"), "set6", 3)
    assert order == ["ours", "other", "other", "ours", "ours", "other"]
    ours, other = rows["set6"]
    assert [times.whole for times in ours] == [1.0, 4.0, 5.0]
    assert [times.whole for times in other] == [2.0, 3.0, 6.0]
    assert speed.in_turn(spends("ours"), None, "set6", 2)["set6"][1] == []


def test_a_row_has_the_median_of_the_ratios_and_their_quartiles():
    others = [1.0, 2.0, 1.0, 2.0, 1.0]
    ratios = [0.5, 0.9, 0.8, 0.7, 9.0]
    ours = [a * b for a, b in zip(others, ratios, strict=True)]
    text = speed.ratio_text(ours, others)
    assert text.split() == ["0.800", "(0.600", "to", "4.950),", "of", "the", "shortest", "0.500"]
    text = speed.ratio_text(ours[:3], others[:3])
    assert "(0.500 to 0.900)" in text  # too few for quartiles


def test_a_row_of_kernels():
    ours, others = [Times(2.0, 1.0)] * 4, [Times(4.0, 4.0)] * 4
    text = speed.row_text("set6", ours, others, with_kernels=True)
    assert text.split()[:4] == ["set6", "2.0000", "s", "0.500"]
    assert "kernels 50 %  0.250 (0.250 to 0.250)" in text
    assert "kernels" not in speed.row_text("set6", ours, others, with_kernels=False)
    assert speed.row_text("set6", ours, [], with_kernels=True).split()[1:] == [
        "2.0000", "s", "kernels", "50", "%",
    ]  # fmt: skip


@pytest.mark.kernels
def test_a_process_does_what_it_is_told():
    with speed.process_of(REPO) as spends:
        times = spends("simulate")["simulate"]
        assert 0.0 < times.kernels < times.whole
        with pytest.raises(SystemExit, match="nothing failed"):
            spends("nothing")


def test_another_package_than_that_of_the_folder_is_refused(tmp_path):
    """Without a package there, Python takes the installed one."""
    with pytest.raises(SystemExit, match="Python loads the package of"), speed.process_of(tmp_path):
        pass


# ---- an empty cache, and the command -------------------------------------------------------------


def test_commands_follow_each_other_with_one_cache():
    write = "import os, pathlib; pathlib.Path(os.environ['NUMBA_CACHE_DIR']).write_text('kernels')"
    read = "import os, pathlib; assert pathlib.Path(os.environ['NUMBA_CACHE_DIR']).exists()"
    costs = cold.costs(REPO, {"first": ["-c", write], "second": ["-c", read]})
    assert list(costs) == ["first", "second"]
    assert all(cost.cpu > 0.0 for cost in costs.values())
    with pytest.raises(SystemExit, match="status 1"):
        cold.costs(REPO, {"first": ["-c", read]})


def test_all_cases_are_listed(capsys):
    speed.main(["--list"])
    lines = capsys.readouterr().out.splitlines()
    names = [line.strip() for line in lines if line.startswith(" ")]
    assert names == [*cases.CASES, "cold"]
    assert [line for line in lines if not line.startswith(" ")] == [
        *(f"{group}:" for group in cases.GROUPS),
        "an empty cache:",
    ]


@pytest.mark.parametrize("words", [["set7"], ["--rounds", "0"]])
def test_a_wrong_request_is_refused(words, capsys):
    with pytest.raises(SystemExit, match="2"):
        speed.main(words)
    assert "allowed: " in capsys.readouterr().err


def test_a_table_of_chosen_cases(monkeypatch, capsys):
    @contextmanager
    def process_of(folder):
        yield lambda name: {name: Times(0.5 if folder == speed.HERE else 1.0, 0.25)}

    monkeypatch.setattr(speed, "process_of", process_of)
    monkeypatch.setattr(speed, "folder_of", lambda state: state)
    monkeypatch.setattr(speed, "cold_of", lambda folder: lambda name: {"first": Times(2.0, 0.0)})
    speed.main(["--against", "before", "set6", "cold", "--rounds", "4"])
    lines = capsys.readouterr().out.splitlines()
    assert lines[0] == "Set 6:"
    assert lines[1].split()[:4] == ["set6", "0.5000", "s", "0.500"]
    assert lines[2] == "an empty cache:"
    assert lines[3].split()[:4] == ["first", "2.0000", "s", "1.000"]
