"""Nasty requests, through every command: status 2, one line, at once, and nothing left behind.

Those of `test_bad_input` are mistakes; these come of file systems, environments and ill will.
"""

import json
import os
import socket
import subprocess
import sys
import time
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest
from made_up import make_scan, write
from test_bad_input import everything

import nlds_vines as nv
from nlds_vines.__main__ import main
from nlds_vines.archives import durable
from nlds_vines.errors import MOST_CHARACTERS, RequestError, printable
from nlds_vines.model.axis import Axis
from nlds_vines.model.system import System
from nlds_vines.runs.manifest import Manifest
from nlds_vines.runs.threads import check_environment
from paper.request_file import load_figure

ODD = "a\udcff"  # how Python keeps the bytes a\xff
SLOW = 2.0  # s of computing: far less than what is refused would take, and kernels are not loaded

SCAN = """\
{title}
system = "ssul-set6"
[vary]
omega = {{ values = [6.0, 7.0] }}
{more}
"""
SYSTEM = """\
[system]
kind = "none"
m1 = 1
k1 = 1
c1 = 1
P = 1
{more}
[vary]
omega = {{ values = [6.0, 7.0] }}
"""
FILES = {
    "null-title.toml": SCAN.format(title='title = "a\\u0000b"', more=""),
    "escape-title.toml": SCAN.format(title='title = "a\\u001B[31mb"', more=""),
    "lines-title.toml": SCAN.format(title='title = "a\\nb"', more=""),
    "c1-title.toml": SCAN.format(title='title = "a\\u009bb"', more=""),
    "long-title.toml": SCAN.format(title=f'title = "{"x" * 10**6}"', more=""),
    "null-name.toml": SYSTEM.format(more='omega = 1\nname = "a\\u0000b"'),
    "long-name.toml": SYSTEM.format(more=f'omega = 1\nname = "{"x" * 10**6}"'),
    "null-note.toml": SYSTEM.format(more='omega = 1\nassumptions = { m1 = "a\\u0000b" }'),
    "escape-note.toml": SYSTEM.format(more='omega = 1\nsources = { m1 = "a\\u001Bb" }'),
    "null-key.toml": SCAN.format(title='"a\\u0000b" = 1', more=""),
    "column.toml": 'system = "tmd"\n[[column]]\nname = "a\\u0000b"\nwindow = [0, 2]\n',
    "curves.toml": SCAN.format(title="", more='[[curves]]\nlabel = "a\\u0000b"\n'),
    "good.toml": SCAN.format(title="", more=""),
}

B, T, P, E = ["bifurcation"], ["tuning"], ["portrait"], ["transients"]
REQUESTS = {
    # bytes that are no UTF-8, and null characters
    "output": ([*B, "-o", f"{ODD}.h5"], ["not UTF-8", "a\\udcff.h5"]),
    "picture": ([*B, "--plot", f"{ODD}.png"], ["not UTF-8"]),
    "scan": ([*B, f"{ODD}.toml"], ["not UTF-8"]),
    "folder": ([*B, "-o", f"{ODD}/x.h5"], ["not UTF-8"]),
    "system": ([*B, "--system", f"{ODD}.toml"], ["not UTF-8"]),
    "parameter": ([*B, "--set", f"{ODD}=1"], ["not UTF-8"]),
    "an option": ([*B, f"--{ODD}"], ["not UTF-8"]),
    "a command": ([ODD], ["unknown command", "a\\udcff"]),
    "null output": ([*B, "-o", "a\0.h5"], ["null character"]),
    "tuning output": ([*T, "-o", f"{ODD}.h5"], ["not UTF-8"]),
    "portrait picture": ([*P, "--plot", f"{ODD}.png"], ["not UTF-8"]),
    "transients output": ([*E, "-o", f"{ODD}.h5"], ["not UTF-8"]),
    "accuracy output": (["accuracy", "-o", f"{ODD}.h5"], ["not UTF-8"]),
    "rerun output": (["rerun", "old.h5", "-o", f"{ODD}.h5"], ["not UTF-8"]),
    "status": (["status", f"{ODD}.h5"], ["not UTF-8"]),
    "consolidate": (["consolidate", f"{ODD}.h5"], ["not UTF-8"]),
    "verify": (["verify", f"{ODD}.h5"], ["not UTF-8"]),
    "diff": (["diff", f"{ODD}.h5", "old.h5"], ["not UTF-8"]),
    # texts
    "null in a title": ([*B, "null-title.toml"], ["null-title.toml", "title", "null"]),
    "escape in a title": ([*B, "escape-title.toml"], ["title", "'\\x1b'", "control"]),
    "lines in a title": ([*B, "lines-title.toml"], ["title", "'\\n'", "line ends"]),
    "C1 in a title": ([*B, "c1-title.toml"], ["title", "'\\x9b'"]),
    "a title of a million": ([*B, "long-title.toml"], ["1000000 characters", "up to 1000"]),
    "null in a name": ([*B, "null-name.toml"], ["[system]", "name", "null"]),
    "a name of a million": ([*B, "long-name.toml"], ["name", "1000000 characters"]),
    "null in an assumption": ([*B, "null-note.toml"], ["assumptions.m1", "null"]),
    "escape in a source": ([*B, "escape-note.toml"], ["sources.m1", "'\\x1b'"]),
    "null in a key": ([*B, "null-key.toml"], ["unknown key 'a\\x00b'"]),
    "null in a column": ([*P, "column.toml"], ["name", "null"]),
    "null in a curve": (["response-curves", "curves.toml"], ["label", "null"]),
    "the title of a tuning": ([*T, "null-title.toml"], ["title"]),
    # numbers
    "underscores": ([*B, "--set", "P=1_000"], ["--set P = '1_000'", "without _"]),
    "Arabic digits": ([*B, "--set", "P=٨٠٠"], ["--set P", "0 to 9"]),
    "full-width digits": ([*B, "--vary", "P=1:2:３"], ["--vary P", "0 to 9"]),
    "periods": ([*B, "--periods", "1_0"], ["--periods", "'1_0'", "without _"]),
    "threads": ([*B, "--threads", "٣"], ["--threads", "0 to 9"]),
    "starts": ([*B, "--start", "random:1_0"], ["--start random:N", "without _"]),
    "a start state": ([*P, "--start", "٠,0,0,0"], ["--start", "0 to 9"]),
    "a window": ([*P, "--windows", "0:1_0"], ["windows", "'0:1_0'", "BEGIN:END"]),
    "samples": ([*P, "--samples", "1_0"], ["--samples", "without _"]),
    "bounds": ([*T, "--free", "k2=1_0:20"], ["--free k2", "without _"]),
    "cases": ([*T, "--over", "P=1_0"], ["--over P", "without _"]),
    "a delay": ([*E, "--delay", "1_0"], ["--delay", "without _"]),
    "periods of accuracy": (["accuracy", "--periods", "2_0"], ["--periods", "without _"]),
    "5000 digits": ([*B, "--periods", "1" * 5000], ["--periods", "whole number"]),
    "hexadecimal": ([*B, "--set", "P=0x10"], ["--set P", "'0x10'"]),
    # sizes and ranges
    "two axes of ten million": (
        [*B, "--vary", "P=1:2:10000000", "--vary", "C=0.1:0.2:10000000"],
        ["10000000 x 10000000 = 100000000000000 cells", "up to 100000000"],
    ),
    "ten million by starts": (
        [*B, "--vary", "P=1:2:10000000", "--vary", "C=0:1:9", "--start", "random:1000"],
        ["90000000000 orbits"],
    ),
    "cases of a tuning": (
        [*T, "--over", "P=1,2", "--over", "m1=1,2", "--band", "5:6:100000000"],
        ["400000000 cases"],
    ),
    "a picture of 1e308": (
        [*B, "--vary", "omega=1e308:1.7e308:2", "--plot", "x.png"],
        ["--plot 'x.png'", "omega = 1e+308", "1e+300"],
    ),
    "a picture of denormal numbers": (
        [*B, "--vary", "P=5e-324:1e-323:2", "--plot", "x.png"],
        ["P = 5e-324", "1e-300"],
    ),
    "an obstacle at 1e308 m": ([*P, "--set", "V=1e308"], ["obstacle at 1e+308 m"]),
    "a surface of 1e308": (
        [*T, "--free", "C=0:1e308", "--free", "k2", "--surface", "C,k2", "--plot", "x.png"],
        ["C = 1e+308", "cannot be drawn"],
    ),
    # files
    "a link to itself": ([*B, "-o", "loop.h5"], ["'loop.h5'", "symbolic links"]),
    "a link to itself, again": ([*B, "-o", "loop.h5", "--overwrite"], ["symbolic links"]),
    "a folder that is such a link": ([*B, "-o", "loop.h5/x.h5"], ["'loop.h5/x.h5'", "no folder"]),
    "a scan that is such a link": ([*B, "loop.toml"], ["loop.toml", "symbolic links"]),
    "a picture that is such a link": ([*B, "--plot", "loop.png"], ["symbolic links"]),
    "a portrait that is such a link": ([*P, "--plot", "loop.png"], ["symbolic links"]),
    "a tuning that is such a link": ([*T, "-o", "loop.h5"], ["symbolic links"]),
    "a pipe for a scan": ([*B, "pipe.toml"], ["pipe.toml", "no regular file"]),
    "a pipe for a tuning": ([*T, "pipe.toml"], ["pipe.toml", "no regular file"]),
    "a pipe for a system": ([*B, "--system", "pipe.toml"], ["no regular file"]),
    "a pipe for an output": ([*B, "-o", "pipe.toml", "--overwrite"], ["no regular file"]),
    "a device for an output": ([*B, "-o", "/dev/null", "--overwrite"], ["no regular file"]),
    "a device for a scan": ([*B, "/dev/zero"], ["/dev/zero", "no regular file"]),
    "a socket for a scan": ([*B, "socket.toml"], ["socket.toml", "no regular file"]),
    "a link to no folder": ([*B, "-o", "nowhere.h5", "--overwrite"], ["no folder"]),
    "a pipe for an archive": (["rerun", "pipe.toml"], ["pipe.toml", "no such file"]),
    "a pipe beside an archive": (["diff", "old.h5", "pipe.toml"], ["no such file"]),
    "a pipe for a manifest": (["status", "piped.h5"], ["manifest.json", "no regular file"]),
    "the same, to join": (["consolidate", "piped.h5"], ["manifest.json", "no regular file"]),
    "a folder for a manifest": (["status", "folded.h5"], ["manifest.json", "no regular file"]),
    "a manifest of other types": (["status", "typed.h5"], ["manifest.json is damaged"]),
    "a manifest nested deeply": (["status", "nested.h5"], ["manifest.json is damaged"]),
    "an output that is its source": (
        [*B, "good.toml", "-o", "hard.h5", "--overwrite"],
        ["another file of this run"],
    ),
    "a page that is its archive": (
        ["accuracy", "-o", "x.h5", "--plot", "x.h5"],
        ["another file of this run"],
    ),
    "a page that is its source": (
        ["accuracy", "good.toml", "--plot", "good.toml"],
        ["another file of this run"],
    ),
    "an archive that is its picture": ([*E, "-o", "x.png"], ["'x.png'", "must end in .h5"]),
    "a port that is none": ([*B, "--scheduler", "tcp://here:99999"], ["tcp://here:99999"]),
}


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """A working folder with nasty files in it."""
    for name, text in FILES.items():
        (tmp_path / name).write_text(text)
    (tmp_path / "old.h5").write_bytes(b"precious")
    os.link(tmp_path / "good.toml", tmp_path / "hard.h5")
    for name in ("loop.h5", "loop.toml", "loop.png"):
        (tmp_path / name).symlink_to(name)
    (tmp_path / "nowhere.h5").symlink_to("no/x.h5")
    os.mkfifo(tmp_path / "pipe.toml")
    for name in ("piped", "folded", "typed", "nested"):
        (tmp_path / f"{name}.h5.parts").mkdir()
    os.mkfifo(tmp_path / "piped.h5.parts" / "manifest.json")
    (tmp_path / "folded.h5.parts" / "manifest.json").mkdir()
    words = {"title": 1, "scan_hash": "", "toml": 3, "argv": [], "began": ""}
    durable.write(tmp_path / "typed.h5.parts" / "manifest.json", json.dumps(words).encode())
    durable.write(tmp_path / "nested.h5.parts" / "manifest.json", b"[" * 100_000)
    monkeypatch.chdir(tmp_path)
    with socket.socket(socket.AF_UNIX) as server:
        server.bind("socket.toml")
        yield tmp_path


@pytest.fixture(autouse=True)
def _nothing_is_computed(monkeypatch):
    def run(*_, **__):
        raise AssertionError("a faulty request has reached the kernels")

    names = {"bifurcation": ("run", "estimate"), "tuning": ("run",), "portrait": ("run",)}
    for wing, modules in {**names, "accuracy": ("measure",), "runs": ("survey",)}.items():
        for name in modules:
            fake = ModuleType(f"nlds_vines.{wing}.{name}")
            vars(fake).update(run=run, estimate=run, views_of=run)
            monkeypatch.setitem(sys.modules, fake.__name__, fake)


@pytest.mark.parametrize("case", REQUESTS)
def test_a_nasty_request_is_one_line_at_once(case, folder, capsys):
    arguments, named = REQUESTS[case]
    before, began = everything(folder), time.process_time()
    assert main(arguments) == 2
    took = time.process_time() - began
    out, err = capsys.readouterr()
    assert out == ""
    assert err.count("\n") == 1
    assert err.startswith("nlds-vines")
    assert "Traceback" not in err
    assert printable(err[:-1]) == err[:-1]
    assert all(word in err for word in named), err
    assert everything(folder) == before
    assert took < SLOW


def test_there_are_enough_of_them():
    assert len(REQUESTS) >= 40


# ---- the environment -----------------------------------------------------------------------------

ENVIRONMENTS = {
    "no threads": ({"NUMBA_NUM_THREADS": "0"}, "NUMBA_NUM_THREADS = '0'"),
    "threads in words": ({"NUMBA_NUM_THREADS": "abc"}, "from 1 to 4096"),
    "no number": ({"NUMBA_NUM_THREADS": ""}, "NUMBA_NUM_THREADS = ''"),
    "threads in Arabic": ({"NUMBA_NUM_THREADS": "٣"}, "NUMBA_NUM_THREADS"),
    "too many threads": ({"NUMBA_NUM_THREADS": "100000"}, "from 1 to 4096"),
}


@pytest.mark.parametrize("case", ENVIRONMENTS)
def test_an_environment_that_numba_refuses_is_one_line(case, folder, monkeypatch, capsys):
    variables, named = ENVIRONMENTS[case]
    with pytest.raises(RequestError, match="in the environment"):
        check_environment(variables)
    for name, value in variables.items():
        monkeypatch.setenv(name, value)
    before = everything(folder)
    for command in ("bifurcation", "tuning", "transients", "portrait", "accuracy"):
        assert main([command]) == 2
        out, err = capsys.readouterr()
        assert (out, err.count("\n")) == ("", 1)
        assert named in err
    assert everything(folder) == before
    if "simulate" not in vars(nv):  # loaded before: then Numba has read its environment
        with pytest.raises(RequestError, match="in the environment"):
            _ = nv.simulate


def test_usual_environments_are_taken():
    check_environment({})
    check_environment({"NUMBA_NUM_THREADS": " 8 "})


@pytest.mark.kernels
def test_the_threads_of_numba_do_not_matter(tmp_path):
    """The threads are our own: what Numba lacks for its own, or would refuse, is not asked for."""
    code = "import sys; from nlds_vines.__main__ import main; sys.exit(main(sys.argv[1:]))"
    arguments = ["bifurcation", "--vary", "omega=6:7:2", "--periods", "1", "--record", "section"]
    done = subprocess.run(
        [sys.executable, "-c", code, *arguments, "-o", "a.h5"],
        capture_output=True,
        text=True,
        cwd=tmp_path,
        env={
            "PYTHONPATH": str(Path(nv.__path__[0]).parent),
            "NUMBA_THREADING_LAYER": "quatsch",
            "NUMBA_DISABLE_JIT": "1",
        },
        check=False,
    )
    assert done.returncode == 0, done.stderr
    assert (tmp_path / "a.h5").exists()


# ---- the same in Python --------------------------------------------------------------------------


def test_python_refuses_the_same():
    with pytest.raises(RequestError, match="null character"):
        nv.load_scan({"title": "a\0b", "system": "tmd", "vary": {"P": {"values": [1.0]}}})
    known = nv.load_system("tmd").parameters
    for name, words in (("a\0", "null"), (ODD, "UTF-8"), ("\x1b[2J", "control"), (3, "a string")):
        with pytest.raises(RequestError, match=words):
            System("tmd", known, name=name)
        with pytest.raises(RequestError, match=words):
            System("tmd", known, assumptions={"m1": name})
    with pytest.raises(RequestError, match="UTF-8"):
        nv.bifurcation(None, f"{ODD}.h5")
    with pytest.raises(RequestError, match=r"characters; allowed: up to 1000"):
        System("tmd", known, title="x" * (MOST_CHARACTERS + 1))


def test_texts_that_people_write_are_taken():
    for title in ("Größe β = 2 π, 減衰", "a 👩‍🔬 b", "$5 \\frac", "x" * MOST_CHARACTERS):
        assert System("tmd", nv.load_system("tmd").parameters, title=title).title == title
    note = "first line\n\tsecond line"
    system = System("tmd", nv.load_system("tmd").parameters, assumptions={"m1": note})
    assert system.assumptions["m1"] == note


def test_an_axis_of_ten_million_values_takes_a_moment():
    began = time.process_time()
    assert Axis.spaced("P", 1.0, 2.0, 10**7).values.size == 10**7
    assert time.process_time() - began < SLOW
    with pytest.raises(RequestError, match="nan must be a finite number"):
        Axis("P", np.array([1.0, np.nan]))


def test_an_archive_made_from_a_program_with_an_odd_name_can_be_written(tmp_path, monkeypatch):
    monkeypatch.setattr(sys, "argv", [f"/home/{ODD}/run.py", "a\0b"])
    path = write(tmp_path / "a.h5", make_scan())
    assert nv.verify(path) == []
    with nv.read(path) as view:
        assert json.loads(view.attrs["argv"]) == sys.argv
    assert Manifest.of(make_scan()).argv == sys.argv


def test_a_file_beyond_all_reason_is_not_read(tmp_path):
    path = tmp_path / "huge.toml"
    with path.open("wb") as file:
        file.truncate(10**12)  # a hole: it takes no room
    with pytest.raises(RequestError, match="1000000000000 bytes; allowed"):
        nv.load_scan(path)


@pytest.mark.parametrize("name", ["../../escaped", "/tmp/escaped", "a/b", "ω" * 900, ".hidden"])
def test_a_name_in_a_figure_is_no_path(tmp_path, name):
    text = SYSTEM.format(more=f'omega = 1\nname = "{name}"') + "[[curves]]\n"
    (tmp_path / "page.toml").write_text(text)
    request = load_figure(tmp_path / "page.toml")
    (archive,) = (request.archive(curve) for curve in request.curves)
    assert Path(archive).name == archive
    assert not archive.startswith(".")
    assert len(archive.encode()) < 255
