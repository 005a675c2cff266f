"""A wrong request: status 2, one line that names it, and nothing left behind.

Single settings are tried in `test_requests`; here are those that depend on each other,
options of many commands, and files.
"""

import os
import re
import shlex
import sys
import time
from types import ModuleType

import pytest
from commands import contents, python
from made_up import MAP, make_scan, write

from nlds_vines.__main__ import COMMANDS, main
from nlds_vines.errors import printable

SLOW = 2.0  # s of computing: far less than what is refused would take, and kernels are not loaded

SYSTEM, OMEGA = 'system = "ssul-set6"', "vary.omega = { start = 5.0, stop = 8.0, num = 3 }"
GOOD = f"""\
title = "good"
{SYSTEM}
{OMEGA}
sampling = {{ transient = 1, periods = 1 }}
record.want = ["section"]
"""


def omega(table):
    return GOOD.replace(OMEGA, f"vary.omega = {{ {table} }}")


def system(table):
    return GOOD.replace(SYSTEM, f"system = {{ {table} }}")


def none(more):
    return system('kind = "none", m1 = 1, k1 = 1, c1 = 1, P = 1' + more)


# what is wrong with the file -> what the line must name
FILES = {
    "unfinished string": ('title = "good\n', ["scan.toml", "line 1", "column"]),
    "key given twice": (GOOD + 'record.want = ["energy"]\n', ["scan.toml", "line 6"]),
    "not text": (b"title = '\xff'\n", ["scan.toml", "not UTF-8"]),
    "empty": ("", ["scan.toml", "no system", "ssul-set6"]),
    "unknown key": (GOOD.replace("title", "titel"), ["scan.toml", "'titel'", "'title'"]),
    "unknown table": (GOOD + "ploting.a = 1\n", ["'ploting'", "sampling"]),
    "escape in a title": (GOOD.replace("good", "a\\u001B[31mb"), ["title", "'\\x1b'", "control"]),
    "null in a name": (none(', omega = 1, name = "a\\u0000b"'), ["[system]", "name", "null"]),
    "no system": (GOOD.replace(SYSTEM, ""), ["scan.toml", "no system", "tmd"]),
    "unknown system": (GOOD.replace("set6", "set7"), ["'ssul-set7'", "'ssul-set6'"]),
    "system without kind": (system("m1 = 1"), ["[system]", "kind is missing", "ssul"]),
    "missing parameter": (none(""), ["[system]", "missing: omega"]),
    "foreign parameter": (none(", omega = 1, k2 = 1"), ["'none'", "'k2'"]),
    "two places": (none(", omega = 1, parameters.m1 = 2"), ["m1", "[system.parameters]"]),
    "unknown parameter": (GOOD + "set.mass = 3", ["[set]", "'mass'", "m1"]),
    "negative mass": (GOOD + "set.m1 = -3", ["[set]", "m1 = -3.0", "> 0"]),
    "NaN": (GOOD + "set.C = nan", ["[set]", "C = nan", "finite"]),
    "set and varied": (GOOD + "set.omega = 6", ["[set]", "omega", "[vary]"]),
    "nothing varied": (GOOD.replace(OMEGA, ""), ["scan.toml", "[vary]", "none"]),
    "unknown axis": (GOOD.replace("omega", "omga"), ["[vary]", "'omga'", "'omega'"]),
    "range without num": (omega("start = 1, stop = 2"), ["omega", "start, stop", "num"]),
    "range and values": (omega("start=1, stop=2, num=3, values=[1]"), ["omega", "values alone"]),
    "equal values": (omega("values = [5, 6, 5]"), ["omega", "5.0", "more than once"]),
    "varied out of range": (GOOD + "vary.m2 = {start=-1, stop=1, num=3}", ["m2 = -1.0", "> 0"]),
    "count without random": (GOOD + "start.count = 3", ["[start]", "'random'", "'rest'"]),
    "impacts without walls": (
        GOOD.replace("section", "impacts").replace("ssul-set6", "tmd"),
        ["[record]", "'impacts'", "'tmd'", "energy"],
    ),
}  # fmt: skip

# what is wrong with options of many commands -> what the line must name, whatever the command
SHARED = {
    "--dry-ru": ["unknown option '--dry-ru'; did you mean '--dry-run'"],
    "--system tdm": ["--system", "'tdm'", "'tmd'"],
    "--system no.toml": ["--system", "no.toml"],
    "--set P": ["--set 'P' must be NAME=VALUE"],
    "--set P=many": ["--set P = 'many' must be a number"],
    "--set P=nan": ["P = nan must be a finite number"],
    "--set P=1 --set P=2": ["--set P is given twice: 1 and 2"],
    "--set mass=1": ["'mass'", "m1"],
    "--threads 0": ["threads = 0"],
    "--resume --overwrite": ["--resume", "--overwrite"],
    "--plot x.gif": ["'x.gif'", ".png, .pdf, .svg"],
    "--plot no/x.png": ["'no/x.png'", "'no'"],
    "-o folder": ["'folder'", "is a folder"],
    "-o a.csv": ["'a.csv'", "must end in .h5"],
    "-o no/x.h5": ["'no/x.h5'", "there is no folder 'no'"],
    "-o old.h5": ["'old.h5' exists", "--resume", "--overwrite"],
    "-o link.h5": ["'link.h5' exists"],
    "-o pipe.toml --overwrite": ["no regular file"],
    "-o same.h5 --plot same.h5": ["same.h5"],
}
TASKS = (
    "bifurcation", "response-curves", "portrait", "continuation", "tuning", "transients",
    "response-history", "accuracy",
)  # fmt: skip
"""Commands that have most of these options."""

SOME_LACK = {"--system", "--set", "--threads", "--resume", "--overwrite", "--plot", "-o"}
NEEDED = {"response-history": ["--impulse", "1"], "transients": ["--plot", "x.png"]}

READERS = ("bifurcation", "continuation", "explore")

# what else is wrong on a command line -> what the line must name
LINES = {
    "bifurcation --viscosity 3": ["unknown option '--viscosity'; allowed:"],
    "bifurcation --recrod energy": ["did you mean '--record'?"],
    "portrait --record energy": ["unknown option '--record'; allowed:"],
    "bifurcation --record sections": ["did you mean 'section'?"],
    "bifurcation --set f3=1": ["did you mean 'f1'?"],
    "bifurcation --vary f2=1:2:3": ["unknown axis 'f2'; did you mean 'f1'?"],
    "bifurcation --set zeta=0.1": ["did you mean 'zeta1'?"],
    "bifurcation --set e=0.7": ["law 'hertz' has no parameter 'e'", "law = 'restitution' has it"],
    "bifurcation --vary e=0.1:0.9:3": ["law = 'restitution' has it"],
    "tuning --free e=0.1:0.9": ["law = 'restitution' has it"],
    "tuning --uncertain e=5%": ["law = 'restitution' has it"],
    "bifurcate": ["unknown command 'bifurcate'; did you mean 'bifurcation'?"],
    "bifurcation --over": ["'--over'", "--overwrite"],
    "bifurcation --set omega=6": ["omega", "figure8.toml: [vary]"],
    "bifurcation --vary omega": ["--vary 'omega' must be NAME=START:STOP:NUM"],
    "bifurcation --vary omega=8:5:3": ["omega", "start = 8.0", "stop = 5.0"],
    "bifurcation --vary P=1:2:3 --vary P=1:2:4": ["--vary P", "twice"],
    "bifurcation --vary P=1:2:3 --vary C=1:2:3 --vary V=1:2:3": ["P, C, V", "two"],
    "bifurcation --start uo": ["[start]", "'uo'", "'up'"],
    "bifurcation --start random": ["--start random:N", "''", "whole"],
    "bifurcation --system tmd --record impacts": ["'impacts'", "'tmd'"],
    "bifurcation --vary P=1:2:5 --vary C=1:2:5 --record section --plot x.png": [
        "--plot 'x.png'", "energy or regime",
    ],
    "bifurcation --shard third": ["--shard 'third'", "i/n", "slurm"],
    "bifurcation --shard 8/7": ["--shard '8/7'", "from 1 to n"],
    "bifurcation --shard slurm": ["SLURM_ARRAY_TASK_ID", "job array"],
    "bifurcation --shard 1/7 --overwrite": ["--shard", "--overwrite"],
    "bifurcation --shard 1/7 --scheduler local:2": ["--scheduler"],
    "bifurcation --scheduler local:0": ["--scheduler local:N", "= 0"],
    "bifurcation --scheduler dask": ["--scheduler 'dask'", "local:N", "tcp://"],
    "bifurcation scan.toml -o hard.h5 --overwrite": ["another file of this run"],
    "bifurcation --periods 1000000000": ["GB of memory", "fewer periods"],
    "bifurcation --periods 1000000000 --dry-run": ["GB of memory"],
    "bifurcation --start random:1000000 --vary P=1:2:9999": ["orbits"],
    "bifurcation --vary omega=1e308:1.7e308:2 --plot x.png": [
        "--plot 'x.png'", "omega = 1e+308", "1e+300",
    ],
    "tuning --over P=1,2 --over m1=1,2 --band 5:6:100000000": ["num = 100000000 must be"],
    "tuning --over P=1,2 --over m1=1,2 --band 5:6:1000000": ["may need", "orbits; allowed: up to"],
    "response-curves --start random:4": ["--start"],
    "portrait --windows 1:5,4:9": ["1:5", "4:9", "follow"],
    "portrait --windows 1:5 --periods 3": ["windows", "periods"],
    "portrait --start up": ["--start", "'up'"],
    "portrait --system none --signal x2": ["'x2'", "'none'"],
    "portrait --resume": ["name it by -o FILE.h5"],
    "portrait --csv a.txt": ["must end in .csv"],
    "portrait --csv no/a.csv": ["there is no folder"],
    "tuning --free k2 --free k2=1:2": ["given twice"],
    "tuning --free omega": ["unknown free parameter 'omega'"],
    "tuning --band 8:5:3": ["start = 8.0 must not be greater"],
    "tuning --band 5:8:3 --over omega=5,6": ["option before it that gives omega exclude each"],
    "continuation --from rest --all": ["--all and"],
    "tuning --system none": ["no damper"],
    "continuation --along omega=5": ["--along omega = '5' must be START:STOP"],
    "continuation --plane P=900:700": ["P from 900 to 700 N: the first must be the lesser"],
    "continuation --along x=5:9": ["unknown parameter 'x'"],
    "continuation --from none.h5": ["there is no such file"],
    **{f"continuation --from {word}": ["the label of a periodic orbit, such as 3T,3"]
       for word in ("banana", "chaos", "1T,1", "T1", "0T,0", "T,01")},
    "continuation --system tmd --along C=1:2": ["C is no parameter of kind 'tmd'"],
    "transients --starts 0": ["count = 0"],
    "transients --tolerance drft": ["tolerance = 'drft'; allowed: 1e-13 to 0.001, or draft"],
    "transients --delay nan": ["delay"],
    "accuracy --want 0": ["--want"],
    "accuracy scan.toml --system tmd": ["scan.toml", "--system tmd"],
    "explore --port 70000": ["--port"],
    "explore map.h5 --set P=3": ["--set"],
    "rerun": ["required", "FILE.h5"],
    "rerun no.h5": ["'no.h5'", "no such file"],
    "rerun old.h5": ["old.h5", "no HDF5 file"],
    "rerun old.h5 -o old.h5 --overwrite": ["old.h5"],
    "report no.h5": ["no.h5"],
    "report map.h5 -o map.h5": ["is another file of this run"],
    **{f"{reader} {files}": named for reader in READERS for files, named in {
        "nothing.toml": ["nothing.toml", "No such file"],
        "folder.toml": ["folder.toml", "no regular file"],
        "pipe.toml": ["pipe.toml", "no regular file"],
        "scan.toml other.toml": ["too many", "other.toml"],
    }.items()},
}  # fmt: skip


@pytest.fixture(scope="module")
def archive(tmp_path_factory):
    path = tmp_path_factory.mktemp("map") / "map.h5"
    return write(path, make_scan(("energy", "regime"), vary=MAP)).read_bytes()


@pytest.fixture
def folder(archive, here):
    """A working folder with a good scan, a map, and things that are in the way."""
    (here / "scan.toml").write_text(GOOD)
    (here / "map.h5").write_bytes(archive)
    (here / "old.h5").write_bytes(b"precious")
    (here / "link.h5").symlink_to("nowhere")
    os.link(here / "scan.toml", here / "hard.h5")
    os.mkfifo(here / "pipe.toml")
    for name in ("folder", "folder.toml"):
        (here / name).mkdir()
    return here


@pytest.fixture(autouse=True)
def nothing_is_computed(monkeypatch):
    def run(*_, **__):
        raise AssertionError("a faulty request has reached the kernels")

    for name in ("bifurcation.run", "tuning.run", "portrait.run", "loads.run", "accuracy.measure"):
        fake = ModuleType(f"nlds_vines.{name}")
        vars(fake).update(run=run, views_of=run)
        monkeypatch.setitem(sys.modules, fake.__name__, fake)


def assert_one_line(status, out, err, named):
    assert (status, out, err.count("\n")) == (2, "", 1)
    assert "Traceback" not in err
    assert printable(err[:-1]) == err[:-1]
    assert all(word in err for word in named), err


@pytest.fixture
def refused(folder, capsys):
    """Return a function that lets a command refuse its words at once, and change nothing."""

    def check(words, named):
        before, began = contents(folder), time.process_time()
        status = main(words)
        assert time.process_time() - began < SLOW
        out, err = capsys.readouterr()
        assert_one_line(status, out, err, named)
        command = f" {words[0]}: error: " if words[0] in COMMANDS else ""
        assert err.startswith(f"nlds-vines{command}")
        assert contents(folder) == before

    return check


@pytest.mark.parametrize("case", FILES)
def test_a_faulty_file(case, folder, refused):
    content, named = FILES[case]
    data = content if isinstance(content, bytes) else content.encode()
    (folder / "scan.toml").write_bytes(data)
    refused(["bifurcation", "scan.toml"], named)


@pytest.mark.parametrize("command", TASKS)
def test_faulty_options_that_many_commands_have(command, refused, capsys):
    assert main([command, "--help"]) == 0
    if "--help-all" in (out := capsys.readouterr().out):
        assert main([command, "--help-all"]) == 0
    lacks = SOME_LACK - set(re.findall(r"(?<![\w-])--?[a-z]+", out + capsys.readouterr().out))
    lines = {line: shlex.split(line) for line in SHARED}
    tried = [line for line, words in lines.items() if not lacks & set(words)]
    assert len(tried) > len(SHARED) / 2
    for line in tried:
        refused([command, *NEEDED.get(command, []), *lines[line]], SHARED[line])


@pytest.mark.parametrize("line", LINES, ids=lambda line: line[:50])
def test_a_faulty_command_line(line, refused):
    refused(shlex.split(line), LINES[line])


def test_the_good_file_reaches_the_kernels(folder):
    # or else every file above could be refused for a reason that is none
    for options in ([], ["-o", "old.h5", "--overwrite"]):
        with pytest.raises(AssertionError, match="reached the kernels"):
            main(["bifurcation", "scan.toml", *options])


@pytest.mark.parametrize("line", ["--system tdm", "--set P=nan", "-o old.h5"])
def test_the_process_answers_likewise(line, folder):
    before = contents(folder)
    done = python("-W", "error", "-m", "nlds_vines.bifurcation", *shlex.split(line))
    assert_one_line(done.returncode, done.stdout, done.stderr, SHARED[line])
    assert contents(folder) == before
