"""The compiled kernels: found by the next process as long as their sources do the same."""

import ast
import hashlib
import json
import os
import shutil
import signal
import stat
import time
from contextlib import contextmanager, suppress
from functools import partial
from pathlib import Path

import numba
import pytest
from commands import ended, printed, started

import nlds_vines
from nlds_vines.kernels.numerics import stored_code

ROOT = Path(nlds_vines.__path__[0]).parent

PROGRAM = """
import json
from nlds_vines import kernels
from nlds_vines.scans.block import Block
from nlds_vines.bifurcation.run import Computer
from nlds_vines.bifurcation.request import load_scan
from nlds_vines.kernels.numerics.compiling import told_of_compilations

document = {
    "system": "none",
    "vary": {"omega": {"values": [5.0, 6.0]}},
    "sampling": {"transient": 0, "periods": 12},
    "record": {"want": ["regime"]},
}
compiled = []
with told_of_compilations(lambda kernel: compiled.append("{0}.{1}".format(*kernel.place))):
    arrays = Computer(load_scan(document), helped=False).block(Block(0, ((0, 2),)))
print(json.dumps({
    "labels": arrays["label"].ravel().tolist(),
    "home": kernels.__path__[0],
    "compiled": [".".join(name.split(".")[-2:]) for name in compiled],
}))
"""


@pytest.fixture(scope="module")
def copy(tmp_path_factory):
    """Return a folder with a copy of the package, and what it has compiled for `PROGRAM`."""
    folder = copied(tmp_path_factory.mktemp("copy"))
    output = run(folder)
    assert "lanes.run_lanes" in output["compiled"]
    assert "lanes.judge_lanes" in output["compiled"]
    assert output["labels"] == ["T,0", "T,0"]
    return folder


def run(folder):
    """Run `PROGRAM` in a copy of the package; return what it prints, and what it says beside."""
    status, out, err = in_copy(folder, "-c", PROGRAM)
    assert status == 0, err
    output = json.loads(out) | {"said": err}
    assert output["home"] == str(folder / "nlds_vines" / "kernels")
    return output


def copied(folder):
    """Copy the package into a folder, without what is compiled."""
    for name in ("nlds_vines", "data", "scans"):
        ignored = shutil.ignore_patterns("__pycache__")
        shutil.copytree(ROOT / name, folder / name, ignore=ignored)
    return folder


def ran(folder, *words, **environment):
    """Run Python in a folder, with a cache there; return its status, its output and its errors."""
    cache = {"NUMBA_DISABLE_JIT": "0", "NUMBA_CACHE_DIR": str(folder / "cache")}
    return ended(started(*words, cwd=folder, **cache | environment))


def in_copy(folder, *words):
    """Run Python with the copy of the package in a folder, and with what it has compiled."""
    return ran(folder, "-B", *words, PYTHONPATH=str(folder))


@contextmanager
def edited(folder, module, before, after, times=1):
    """Change a text in a module of the kernels, within the block, and let it begin a line later."""
    (path,) = (folder / "nlds_vines" / "kernels").glob(f"*/{module}.py")
    text = path.read_text()
    assert text.count(before) >= times
    path.write_text("# a comment\n" + text.replace(before, after))
    try:
        yield
    finally:
        path.write_text(text)


@pytest.mark.kernels
def test_neither_a_second_process_nor_another_docstring_or_comment_compiles_anything(copy):
    again = run(copy)
    assert again["compiled"] == []
    assert again["labels"] == ["T,0", "T,0"]
    with edited(copy, "flight", '    """Return', '    """Now\n\n    return', times=4):
        assert run(copy)["compiled"] == []


@pytest.mark.kernels
def test_a_change_is_seen_where_it_acts_compiles_nothing_else_and_removes_what_was(copy):
    """`judge_lanes` stands in another file than what is changed; flights know nothing of it."""
    before = {path.name for path in (copy / "cache").rglob("*.compiled")}
    with edited(copy, "verdict", "MARGIN = 1.0e-6", "MARGIN = 1.0e+6"):  # nothing is stable
        output = run(copy)
        assert not before & {path.name for path in (copy / "cache").rglob("verdict.*.compiled")}
    assert output["labels"] == ["undetermined", "undetermined"]  # it returns, and nothing draws it
    assert "lanes.judge_lanes" in output["compiled"]
    assert not any(name.startswith(("flight", "fours", "touch")) for name in output["compiled"])
    assert run(copy)["labels"] == ["T,0", "T,0"]


NONSENSE = b"of another program"
DAMAGES = {
    "cut": lambda data: data[:-100],
    "flipped": lambda data: data[:-9] + bytes([data[-9] ^ 4]) + data[-8:],
    "empty": lambda data: b"",
    "whole, but no code": lambda data: hashlib.sha256(NONSENSE).digest() + NONSENSE,
    "removed": None,
}
"""What becomes of the bytes of a file."""


def damage(path, kind):
    if kind == "removed":
        path.unlink()
    else:
        path.write_bytes(DAMAGES[kind](path.read_bytes()))


@pytest.mark.kernels
@pytest.mark.parametrize("kind", ["flipped", "removed"])
@pytest.mark.parametrize("which", ["lanes.run_lanes", "flight."])
def test_a_damaged_cache_heals_itself(copy, which, kind):
    """Of entries and of inner kernels; one function reads both, which another test has damaged."""
    files = [path for path in (copy / "cache").rglob(f"{which}*") if path.is_file()]
    assert files
    entries = {path.name: path for path in (copy / "cache").rglob("lanes.run_lanes*")}
    for path in {*files, *entries.values()}:  # inner kernels are read where an entry is not
        damage(path, kind if path in files else "removed")
    output = run(copy)
    assert output["labels"] == ["T,0", "T,0"]
    assert "lanes.run_lanes" in output["compiled"]
    assert output["said"].count("\n") == (0 if kind == "removed" else 1)
    assert run(copy)["compiled"] == []


def test_a_stamp_is_that_of_a_module_and_of_what_it_imports():
    for source, names in {
        b"from .touch import bound\ndef f(x):\n    return bound(x)": ["bound", "touch"],
        b"import math\nfrom numpy import pi": [],
    }.items():
        assert stored_code.read_source(source)[1] == names
    source = b"from nlds_vines.kernels.numerics import fours as f"
    assert "fours" in stored_code.read_source(source)[1]
    stamps = {path.stem: stored_code.stamp_of(path) for path in stored_code.KERNELS.glob("*/*.py")}
    assert stamps["flight"] != stamps["verdict"] != stamps["touch"]


@pytest.mark.parametrize("level", ["3", "1"])
def test_the_stamp_knows_how_much_is_optimized(level):
    """Numba's key of a compiled function does not."""
    program = """
from nlds_vines.kernels.numerics import stored_code
print(stored_code.stamp_of(stored_code.KERNELS / "numerics" / "fours.py"))
"""
    stamp = stored_code.stamp_of(stored_code.KERNELS / "numerics" / "fours.py")
    other = printed("-c", program, NUMBA_OPT=level).strip()
    assert (other == stamp) == (int(level) == numba.config.OPT)


# ---- where nothing can be written ----------------------------------------------------------------

BLOCKED = """
from nlds_vines.kernels.numerics.elementary import exp
print(exp(1.0))
"""


@pytest.fixture(scope="module")
def package(tmp_path_factory):
    """Return a folder with a copy of the package that takes no cache.

    A file in its place keeps even the superuser from writing one.
    """
    folder = copied(tmp_path_factory.mktemp("package"))
    (folder / "nlds_vines" / "kernels" / "__pycache__").touch()
    return folder


def run_without_a_cache(package, home, temporary, code=BLOCKED, **others):
    """Run a program, which prints e, in a folder of `package`; return its errors."""
    places = {"TMPDIR": str(temporary), "HOME": str(home), "XDG_CACHE_HOME": f"{home}/cache"}
    environment = {**places, "NUMBA_CACHE_DIR": "", "PYTHONPATH": "", **others}
    status, out, err = ran(package, "-B", "-c", code, **environment)
    assert status == 0, err
    assert float(out) == pytest.approx(2.718281828459045, rel=1e-15)
    return err


@pytest.fixture
def blocked(package, tmp_path):
    """Return `run_without_a_cache` of the package."""
    (tmp_path / "tmp").mkdir()
    return partial(run_without_a_cache, package)


def compiled_in(folder):
    return list(folder.rglob("*.compiled"))


@pytest.fixture(scope="module")
def cache_of_a_user(package, tmp_path_factory):
    """Return the home of a user who has run `BLOCKED`, with the usual modes of files."""
    home = tmp_path_factory.mktemp("user") / "home"
    before = os.umask(0o022)
    try:
        assert run_without_a_cache(package, home, tmp_path_factory.mktemp("tmp")) == ""
    finally:
        os.umask(before)
    assert compiled_in(home)
    return home


@pytest.fixture
def home(cache_of_a_user, tmp_path):
    """Return a copy of it."""
    return Path(shutil.copytree(cache_of_a_user, tmp_path / "home"))


def test_then_a_temporary_folder_that_is_named_unless_others_can_write_to_it(blocked, tmp_path):
    err = blocked("/dev/null", tmp_path / "tmp")
    assert err.count("\n") == 1
    assert "NUMBA_CACHE_DIR" in err
    (folder,) = (tmp_path / "tmp").iterdir()
    assert str(folder) in err
    assert folder.stat().st_mode & 0o077 == 0  # what lies there is run
    assert compiled_in(folder)
    before = {path: path.stat().st_mtime_ns for path in compiled_in(folder)}
    assert str(folder) in blocked("/dev/null", tmp_path / "tmp")  # the same again
    assert {path: path.stat().st_mtime_ns for path in compiled_in(folder)} == before
    theirs = tmp_path / "theirs" / folder.name
    theirs.mkdir(parents=True)
    theirs.chmod(0o777)
    assert f"{theirs};" not in blocked("/dev/null", theirs.parent)
    assert not compiled_in(theirs)


@pytest.mark.slow("six processes that load the compiler")
def test_the_users_cache_is_taken_without_a_word_and_heals_itself(blocked, home, tmp_path):
    """In all ways, what is compiled for `BLOCKED`; another test has inner kernels, too."""
    assert blocked(home, tmp_path / "tmp") == ""
    assert not compiled_in(tmp_path / "tmp")
    sound = {path: path.read_bytes() for path in compiled_in(home)}
    for kind in DAMAGES:
        for path in sound:
            damage(path, kind)
        err = blocked(home, tmp_path / "tmp")
        assert err.count("\n") == (0 if kind == "removed" else 1)
        assert {path: path.read_bytes() for path in compiled_in(home)} == sound


def test_a_numba_cache_dir_that_is_passed_over_is_said(blocked, package, tmp_path):
    """Because it is a file, or because others may write to it."""
    home, file, theirs = tmp_path / "home", tmp_path / "file", tmp_path / "theirs"
    file.touch()
    (theirs / "nlds_vines").mkdir(parents=True)
    name = stored_code.folder_name(package / "nlds_vines" / "kernels")
    (theirs / "nlds_vines" / name).mkdir()
    (theirs / "nlds_vines" / name).chmod(0o777)
    for place, reason in ((file, "Not a directory"), (theirs, "others may write to it")):
        (line,) = blocked(home, tmp_path / "tmp", NUMBA_CACHE_DIR=str(place)).splitlines()
        assert line.startswith(f"nlds_vines: NUMBA_CACHE_DIR = {str(place)!r} is passed over: ")
        assert reason in line
        assert line.endswith(f"; compiled kernels go to {home}/cache/nlds_vines/{name}")
    assert not compiled_in(theirs)


def test_without_any_folder_it_works_all_the_same(blocked):
    nowhere = 'import tempfile\ntempfile.gettempdir = lambda: "/dev/null"'
    err = blocked("/dev/null", "/dev/null", nowhere + BLOCKED)
    assert err.count("\n") == 1
    assert "are lost when the process ends; set NUMBA_CACHE_DIR" in err


# ---- who may have written what is run ------------------------------------------------------------

OTHER = 4242
"""A user who is not the one that runs the tests."""


@pytest.mark.slow("processes that load the compiler")
@pytest.mark.parametrize(
    ("kind", "who"),
    [
        ("folder", "it belongs to another"), ("folder", "its group"), ("folder", "all others"),
        ("files", "it belongs to another"), ("files", "all others"),
    ],
)  # fmt: skip
def test_what_others_may_have_written_is_not_read(blocked, home, tmp_path, kind, who):
    if who == "it belongs to another" and os.getuid() != 0:
        pytest.skip("only the superuser gives files to other users")
    (folder,) = {path.parent for path in compiled_in(home)}
    for path in [folder] if kind == "folder" else [*folder.iterdir()]:
        if who == "it belongs to another":
            os.chown(path, OTHER, OTHER)
        else:
            path.chmod(path.stat().st_mode | (0o020 if who == "its group" else 0o002))
    files = {path: path.stat() for path in compiled_in(folder)}
    err = blocked(home, tmp_path / "tmp")
    named = [line for line in err.splitlines() if f"{folder} are not read" in line]
    assert len(named) == 1
    if kind == "folder":  # nothing is written there either
        assert {path: path.stat() for path in compiled_in(folder)} == files
    else:  # they are replaced
        assert blocked(home, tmp_path / "tmp") == ""


def test_the_files_of_root_are_read_by_all(blocked, package, home):
    """What an administrator compiled: the folder cannot be written, its files have usual modes."""
    if os.getuid() != 0:
        pytest.skip("only the superuser becomes another user")
    files = compiled_in(home)
    assert {stat.S_IMODE(path.stat().st_mode) for path in files} == {0o644}
    for path in (package, home):
        for folder in [path, *path.parents][:-2]:
            folder.chmod(folder.stat().st_mode | 0o055)
    program = f"""
import os
from nlds_vines.kernels.numerics import stored_code
os.setgid({OTHER}), os.setuid({OTHER})
read = [stored_code.load(name) for name in {[path.name for path in files]}]
print(2.718281828459045 if all(read) else 0.0)
"""
    assert blocked(home, "/dev/null", program).count("\n") == 1  # its own are lost


@pytest.mark.parametrize("mask", [0o000, 0o002, 0o027, 0o077])
def test_the_umask_decides_who_may_read(tmp_path, mask):
    before = os.umask(mask)
    try:
        stored_code._write_whole(tmp_path / "a", b"code")
    finally:
        os.umask(before)
    assert stat.S_IMODE((tmp_path / "a").stat().st_mode) == 0o644 & ~mask


PLACES = """
import os
from nlds_vines.kernels.numerics import stored_code
os.setgid(54321), os.setuid(54321)  # who has no entry in the list of users
print([str(place) for place in stored_code._places()])
"""


def test_a_user_without_a_home_and_a_relative_cache(monkeypatch):
    if os.getuid() != 0:
        pytest.skip("only the superuser becomes another user")
    for name in ("HOME", "XDG_CACHE_HOME", "NUMBA_CACHE_DIR"):
        monkeypatch.delenv(name, raising=False)
    places = [
        [Path(place) for place in ast.literal_eval(printed("-B", "-c", PLACES, **settings))]
        for settings in ({}, {"XDG_CACHE_HOME": "cache", "HOME": "/h"})
    ]
    assert places[0] == [stored_code.KERNELS / "__pycache__"]
    assert places[1][1].parent == Path("/h/.cache/nlds_vines")


# ---- what a run does with what it finds, or does not find ----------------------------------------


SAYS = "compiling the equations of {} into machine code"


def says_at_first(folder, *words, **environment):
    """Return the first line of a command's errors, after which it is ended."""
    where = {"NUMBA_DISABLE_JIT": "0", "NUMBA_CACHE_DIR": str(folder / "cache"), **environment}
    with started("-m", "nlds_vines", *words, cwd=folder, **where) as process:
        line = process.stderr.readline()
        process.kill()
    return line


@pytest.mark.slow("a command that loads the compiler")
def test_what_is_compiled_under_a_load_is_said(tmp_path):
    words = "response-history --system none --impulse 1000 --duration 20 -o a.h5"
    assert SAYS.format("none") in says_at_first(tmp_path, *words.split())


@pytest.mark.kernels
def test_a_run_finds_what_was_compiled_and_says_what_was_not(tmp_path):
    scan = "bifurcation --system none --vary omega=6:7:2 --record section --transient 1 --periods 2"
    words = *scan.split(), "--overwrite", "-o", "a.h5"
    assert ran(tmp_path, "-m", "nlds_vines", *words, "--quiet")[::2] == (0, "")
    assert ran(tmp_path, "-m", "nlds_vines", *words)[::2] == (0, "")
    said = f"{SAYS.format('none')}, which is kept for later runs: about 12 s\n"
    assert says_at_first(tmp_path, *words, NUMBA_OPT="2") == said


@pytest.mark.kernels
@pytest.mark.skipif(numba.config.DISABLE_JIT, reason="nothing is compiled")
def test_what_is_compiled_for_branches_is_what_a_continuation_calls(copy):
    """In a process of its own, whose second half would compile what the first has left out."""
    program = """
from nlds_vines.engine.section_map import KERNELS, SectionMap
from nlds_vines.kernels.numerics.compiling import told_of_compilations
import nlds_vines as nv
system = nv.load_system("none")
SectionMap(system, ("omega",)).compile(None)
nv.classify(system)
compiled = []
with told_of_compilations(compiled.append):
    found = nv.continue_branch(system, "omega", (6.2, 6.3))
assert len(found.branches[0]) > 2
print([kernel.py_func.__name__ for kernel in compiled if kernel in KERNELS])
"""
    assert in_copy(copy, "-c", program)[:2] == (0, "[]\n")


def children(pid):
    """Return the processes in which the threads of a process have begun to compile."""
    helpers = []
    with suppress(FileNotFoundError, ProcessLookupError):  # of what ends meanwhile
        for task in Path(f"/proc/{pid}/task").iterdir():
            listed = task / "children"
            if listed.parent.is_dir() and not listed.exists():
                pytest.skip("the system does not show them")
            for child in listed.read_text().split():
                if b"compile_verdict" in Path(f"/proc/{child}/cmdline").read_bytes():
                    helpers.append(int(child))
    return helpers


def alive(pid):
    try:
        os.kill(pid, 0)
    except ProcessLookupError:
        return False
    return Path(f"/proc/{pid}/stat").read_text().split(")")[1].split()[0] != "Z"


BOUND = 300
"""Seconds after which a process that should end at once is taken for one that does not end."""


@pytest.mark.parametrize(
    ("threads", "end"), [(2, signal.SIGINT), (2, signal.SIGKILL), (1, signal.SIGINT)]
)
def test_nothing_goes_on_after_the_end(threads, end, tmp_path):
    """The default scan, with an empty cache; on one thread nobody helps to compile."""
    helpers, process = [], started(
        "-m", "nlds_vines", "bifurcation", "--threads", threads, cwd=tmp_path,
        NUMBA_DISABLE_JIT="0", NUMBA_CACHE_DIR=str(tmp_path),
    )  # fmt: skip
    if threads == 1:
        assert process.stderr.readline().startswith("compiling the equations of ssul")
    while threads > 1 and not (helpers := children(process.pid)):
        assert process.poll() is None
        time.sleep(0.02)
    assert not list(tmp_path.rglob("lanes.*.compiled"))
    process.send_signal(end)
    _, err = process.communicate(timeout=BOUND)
    if end == signal.SIGINT:
        assert process.returncode == 130
        assert "interrupted: 0 of " in err
    while any(alive(child) for child in helpers):
        time.sleep(0.02)
    assert not list(tmp_path.rglob("lanes.*.compiled"))  # none was compiled to its end
