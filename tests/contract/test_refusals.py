"""Whatever is wrong with what is asked: status 2, one line that names it, and nothing left behind.

Mistakes, and what comes of file systems and ill will. Settings are tried in
`test_checked_settings`.
"""

import json
import os
import re
import shlex
import socket
import sys
import time
from types import ModuleType

import pytest
from commands import contents, python
from made_up import MAP, make_scan, write

from nlds_vines.__main__ import main
from nlds_vines.archives import durable
from nlds_vines.cli.commands import COMMANDS
from nlds_vines.errors import printable

ODD = "a\udcff"  # how Python keeps the bytes a\xff
SLOW = 2.0  # s of computing: far less than what is refused would take, and kernels are not loaded

GOOD = """\
title = "good"
system = "ssul-set6"
[vary]
omega = { start = 5.0, stop = 8.0, num = 3 }
[sampling]
transient = 1
periods = 1
[record]
want = ["section"]
"""
NONE = 'kind = "none"\nm1 = 1\nk1 = 1\nc1 = 1\nP = 1\n'


def without(line):
    """The good file without the line that begins like this."""
    return "\n".join(each for each in GOOD.splitlines() if not each.startswith(line))


def table(name, content):
    """The good file with one table's content replaced or added."""
    tables = re.split(r"^(?=\[)", GOOD, flags=re.MULTILINE)
    others = [each for each in tables if not each.startswith(f"[{name}]")]
    return "".join(others) + f"[{name}]\n{content}\n"


def system(content):
    return without("system") + f"\n[system]\n{content}\n"


def none(more):
    return system(f"{NONE}omega = 1\n{more}")


def setting(content):
    return table("set", content)


def vary(content):
    return table("vary", content)


def omega(content):
    return vary(f"omega = {content}")


def title(text):
    return GOOD.replace("good", text)


# what is wrong with the file -> what the line must name
FILES = {
    # not TOML
    "unfinished string": ('title = "good\n', ["scan.toml", "line 1", "column"]),
    "unfinished array": ("system = [1,\n", ["scan.toml", "line 2", "column 1"]),
    "no equals sign": ('system = "tmd"\nvary\n', ["scan.toml", "line 2"]),
    "key given twice": (GOOD + 'want = ["energy"]\n', ["scan.toml", "line 10"]),
    "table given twice": (GOOD + "[vary]\n", ["scan.toml", "line 10"]),
    "nested too deeply": ("a = " + "[" * 5000 + "]" * 5000, ["scan.toml", "nested too deeply"]),
    "not text": (b"title = '\xff'\n", ["scan.toml", "not UTF-8"]),
    "empty": ("", ["scan.toml", "no system", "ssul-set6"]),
    # unknown keys
    "unknown key": (GOOD.replace("title", "titel"), ["scan.toml", "'titel'", "'title'"]),
    "unknown table": (GOOD + "[ploting]\na = 1\n", ["'ploting'", "sampling"]),
    "unknown key of vary": (vary("P = { strat = 1, stop = 2, num = 3 }"), ["'strat'", "'start'"]),
    "unknown key of system": (system(NONE + "omgea = 2\n"), ["[system]", "'omgea'", "'omega'"]),
    "null in a key": ('"a\\u0000b" = 1\n' + GOOD, ["unknown key 'a\\x00b'"]),
    # texts
    "title is a number": (GOOD.replace('"good"', "8"), ["scan.toml", "title = 8", "string"]),
    "null in a title": (title("a\\u0000b"), ["scan.toml: title", "null"]),
    "escape in a title": (title("a\\u001B[31mb"), ["title", "'\\x1b'", "control"]),
    "lines in a title": (title("a\\nb"), ["title", "'\\n'", "line ends"]),
    "C1 in a title": (title("a\\u009bb"), ["title", "'\\x9b'"]),
    "a title of a million": (title("x" * 10**6), ["1000000 characters", "up to 1000"]),
    "null in a name": (none('name = "a\\u0000b"'), ["[system]", "name", "null"]),
    "a name of a million": (none(f'name = "{"x" * 10**6}"'), ["name", "1000000 characters"]),
    "null in a note": (none('assumptions = { m1 = "a\\u0000b" }'), ["assumptions.m1", "null"]),
    "escape in a source": (none('sources = { m1 = "a\\u001Bb" }'), ["sources.m1", "'\\x1b'"]),
    "source is no text": (none("sources = { m1 = 3 }"), ["sources.m1 = 3"]),
    # system
    "no system": (without("system"), ["scan.toml", "no system", "tmd"]),
    "unknown system": (GOOD.replace("set6", "set7"), ["'ssul-set7'", "'ssul-set6'"]),
    "system is a number": (GOOD.replace('"ssul-set6"', "6"), ["system = 6", "[system] table"]),
    "system without kind": (system("m1 = 1"), ["[system]", "kind is missing", "ssul"]),
    "unknown kind": (system('kind = "sssul"'), ["'sssul'", "'ssul'"]),
    "kind is a list": (system("kind = []"), ["kind", "[]", "ssul"]),
    "missing parameter": (system(NONE), ["[system]", "missing: omega"]),
    "foreign parameter": (none("k2 = 1\n"), ["'none'", "'k2'"]),
    "parameters are no table": (system('kind = "tmd"\nparameters = 3'), ["parameters = 3"]),
    "parameter in two places": (none("[system.parameters]\nm1 = 2"), ["m1", "[system.parameters]"]),
    # set
    "unknown parameter": (setting("mass = 3"), ["[set]", "'mass'", "m1"]),
    "parameter of another kind": (setting("D = 3"), ["[set]", "'D'", "'ssul'"]),
    "negative mass": (setting("m1 = -3"), ["[set]", "m1 = -3.0", "> 0"]),
    "Poisson's ratio": (setting("nu1 = 0.7"), ["nu1 = 0.7", "0.5"]),
    "NaN": (setting("C = nan"), ["[set]", "C = nan", "finite"]),
    "infinity": (setting("k1 = -inf"), ["[set]", "k1 = -inf", "finite"]),
    "huge integer": (setting("k1 = 1" + "0" * 400), ["k1 = 1000", "finite"]),
    "text for a number": (setting('P = "800"'), ["P = '800'", "number"]),
    "bool for a number": (setting("P = true"), ["P = True", "number"]),
    "date for a number": (setting("P = 2020-01-01"), ["P = ", "number"]),
    "set is no table": ("set = 3\n" + GOOD, ["[set]", "set = 3", "table"]),
    "K beside a modulus": (setting("K = 1e7\nE1 = 1e9"), ["[set]", "K beside E1"]),
    "A and B zero": (setting("A = 0\nB = 0"), ["A + B must be > 0"]),
    "set and varied": (setting("omega = 6"), ["[set]", "omega", "[vary]"]),
    "zero frequency": (
        vary("P = { values = [1] }\n[set]\nomega = 0"),
        ["[set]", "omega = 0.0", "> 0"],
    ),
    # vary
    "nothing varied": (without("omega"), ["scan.toml", "[vary]", "none"]),
    "unknown axis": (vary("omga = { values = [1] }"), ["[vary]", "'omga'", "'omega'"]),
    "axis is a list": (omega("[1, 2]"), ["[vary] omega", "[1, 2]", "table"]),
    "axis is empty": (omega("{}"), ["[vary] omega", "nothing given", "values"]),
    "range without num": (omega("{ start = 1, stop = 2 }"), ["omega", "start, stop", "num"]),
    "range and values": (
        omega("{ start = 1, stop = 2, num = 3, values = [1] }"),
        ["omega", "values alone"],
    ),
    "start = stop": (omega("{ start = 5, stop = 5, num = 2 }"), ["omega", "5.0", "once"]),
    "num = 0": (omega("{ start = 5, stop = 8, num = 0 }"), ["omega", "num = 0", "1"]),
    "num absurd": (omega("{ start = 5, stop = 8, num = 10000001 }"), ["= 10000001", "10000000"]),
    "num not whole": (omega("{ start = 5, stop = 8, num = 3.0 }"), ["num = 3.0", "whole"]),
    "num is a bool": (omega("{ start = 5, stop = 8, num = true }"), ["num = True", "whole"]),
    "NaN in a range": (omega("{ start = nan, stop = 8, num = 3 }"), ["start = nan"]),
    "overflowing range": (vary("C = { start = -1.7e308, stop = 1.7e308, num = 3 }"), ["C", "nan"]),
    "no values": (omega("{ values = [] }"), ["omega", "0 values", "1"]),
    "equal values": (omega("{ values = [5, 6, 5] }"), ["omega", "5.0", "more than once"]),
    "values are a number": (omega("{ values = 5 }"), ["omega", "values = 5", "list"]),
    "values are text": (omega('{ values = "56" }'), ["omega", "values = '56'", "list"]),
    "infinite value": (omega("{ values = [5, inf] }"), ["omega = inf", "finite"]),
    "bool among values": (omega("{ values = [5, true] }"), ["omega = True", "number"]),
    "varied out of range": (vary("m2 = { start = -1, stop = 1, num = 3 }"), ["m2 = -1.0", "> 0"]),
    # start, record
    "count without random": (table("start", "count = 3"), ["[start]", "'random'", "'rest'"]),
    "impacts without walls": (
        table("record", 'want = ["impacts"]').replace("ssul-set6", "tmd"),
        ["[record]", "'impacts'", "'tmd'", "energy"],
    ),
}

# what is wrong with options of many commands -> what the line must name, whatever the command
SHARED = {
    "--dry-ru": ["unknown option '--dry-ru'; did you mean '--dry-run'"],
    f"--{ODD}": ["not UTF-8"],
    "--system tdm": ["--system", "'tdm'", "'tmd'"],
    "--system no.toml": ["--system", "no.toml"],
    "--system ../../etc/passwd": ["../../etc/passwd"],
    "--system pipe.toml": ["no regular file"],
    f"--system {ODD}.toml": ["not UTF-8"],
    "--set P": ["--set 'P' must be NAME=VALUE"],
    "--set P=": ["--set 'P=' must be NAME=VALUE"],
    "--set P=many": ["--set P = 'many' must be a number"],
    "--set P=1_000": ["--set P = '1_000' must be a number in the digits 0 to 9, without _"],
    "--set P=٨٠٠": ["--set P", "in the digits 0 to 9"],
    "--set P=0x10": ["--set P", "'0x10'"],
    "--set P=nan": ["P = nan must be a finite number"],
    "--set P=1 --set P=2": ["--set P is given twice: 1 and 2"],
    "--set mass=1": ["'mass'", "m1"],
    "--set m1=-1": ["m1 = -1.0 is not allowed"],
    f"--set {ODD}=1": ["not UTF-8"],
    "--threads 0": ["threads = 0"],
    "--threads 100000": ["threads = 100000", "4096"],
    "--threads ٣": ["--threads", "0 to 9"],
    "--resume --overwrite": ["--resume", "--overwrite"],
    "--plot": ["--plot", "one argument"],
    "--plot x.gif": ["'x.gif'", ".png, .pdf, .svg"],
    "--plot no/x.png": ["'no/x.png'", "'no'"],
    "--plot folder.png": ["'folder.png'", "is a folder"],
    "--plot loop.png": ["symbolic links"],
    f"--plot {ODD}.png": ["not UTF-8"],
    "-o folder": ["'folder'", "is a folder"],
    "-o a.csv": ["'a.csv'", "must end in .h5"],
    "-o a.png": ["'a.png'", "must end in .h5"],
    "-o no/x.h5": ["'no/x.h5'", "there is no folder 'no'"],
    "-o old.h5/x.h5": ["old.h5"],
    "-o /proc/x.h5": ["/proc/x.h5", "cannot be written"],
    f"-o {'x' * 300}": ["xxx", "too long"],
    "-o old.h5": ["'old.h5' exists", "--resume", "--overwrite"],
    "-o link.h5": ["'link.h5' exists"],
    "-o loop.h5": ["'loop.h5'", "symbolic links"],
    "-o loop.h5 --overwrite": ["symbolic links"],
    "-o loop.h5/x.h5": ["'loop.h5/x.h5'", "no folder"],
    "-o nowhere.h5 --overwrite": ["no folder"],
    "-o pipe.toml --overwrite": ["no regular file"],
    "-o /dev/null --overwrite": ["no regular file"],
    "-o same.h5 --plot same.h5": ["same.h5"],
    f"-o {ODD}.h5": ["not UTF-8", "a\\udcff.h5"],
    f"-o {ODD}/x.h5": ["not UTF-8"],
    "-o 'a\0.h5'": ["null"],
}
TASKS = (
    "bifurcation", "response-curves", "portrait", "continuation", "tuning", "transients", "decay",
    "accuracy",
)  # fmt: skip
"""Commands that have most of these options."""

SOME_LACK = {"--system", "--set", "--threads", "--resume", "--overwrite", "--plot", "-o"}
NEEDED = {"decay": ["--impulse", "1"], "transients": ["--plot", "x.png"]}

# wrong files of commands that read one -> what the line must name
READERS = ("bifurcation", "response-curves", "portrait", "continuation", "tuning", "explore")
UNREADABLE = {
    "nothing.toml": ["nothing.toml", "No such file"],
    "folder.toml": ["folder.toml", "Is a directory"],
    "loop.toml": ["loop.toml", "symbolic links"],
    "pipe.toml": ["pipe.toml", "no regular file"],
    "socket.toml": ["socket.toml", "no regular file"],
    f"{ODD}.toml": ["not UTF-8"],
    "scan.toml other.toml": ["too many", "other.toml"],
}

# what else is wrong on a command line -> what the line must name
LINES = {
    ODD: ["unknown command", "a\\udcff"],
    "bifurcate": ["unknown command 'bifurcate'; did you mean 'bifurcation'?"],
    "bifurcation --over": ["'--over'", "--overwrite"],
    "bifurcation 'a\nb\r\u2028c.toml'": ["a b c.toml"],
    "bifurcation --set 'm\n1=2'": ["unknown parameter"],
    "bifurcation --set omega=6": ["omega", "figure8.toml: [vary]"],
    "bifurcation --set P=1 --vary P=1:2:3": ["P", "command line: [vary]"],
    "bifurcation --vary omega": ["--vary 'omega' must be NAME=START:STOP:NUM"],
    "bifurcation --vary omega=5:8": ["--vary omega", "'5:8'", "START:STOP:NUM"],
    "bifurcation --vary omega=a:8:3": ["--vary omega", "'a'", "number"],
    "bifurcation --vary omega=5:8:3.5": ["--vary omega", "'3.5'", "whole"],
    "bifurcation --vary P=1:2:３": ["--vary P", "0 to 9"],
    "bifurcation --vary omega=8:5:3": ["omega", "start = 8.0", "stop = 5.0"],
    "bifurcation --vary omega=5:8:0": ["omega", "num = 0"],
    "bifurcation --vary P=1:2:3 --vary P=1:2:4": ["--vary P", "twice"],
    "bifurcation --vary P=1:2:3 --vary C=1:2:3 --vary V=1:2:3": ["P, C, V", "two"],
    "bifurcation --start uo": ["[start]", "'uo'", "'up'"],
    "bifurcation --start up:3": ["'up:3'", "'up'"],
    "bifurcation --start random": ["--start random:N", "''", "whole"],
    "bifurcation --start random:0": ["count = 0"],
    "bifurcation --start random:1_0": ["--start random:N", "without _"],
    "bifurcation --system tmd --record impacts": ["'impacts'", "'tmd'"],
    "bifurcation --vary P=1:2:5 --vary C=1:2:5 --record section --plot x.png": [
        "--plot 'x.png'", "energy or regime",
    ],
    "bifurcation --shard third": ["--shard 'third'", "i/n", "slurm"],
    "bifurcation --shard 0/7": ["--shard '0/7'", "from 1 to n"],
    "bifurcation --shard 8/7": ["--shard '8/7'", "from 1 to n"],
    "bifurcation --shard 1/99999": ["--shard '1/99999'", "10000"],
    "bifurcation --shard slurm": ["SLURM_ARRAY_TASK_ID", "job array"],
    "bifurcation --shard 1/7 --overwrite": ["--shard", "--overwrite"],
    "bifurcation --shard 1/7 --scheduler local:2": ["--scheduler"],
    "bifurcation --shard 1/7 --plot x.png": ["--plot 'x.png'", "a shard draws nothing"],
    "bifurcation --scheduler dask": ["--scheduler 'dask'", "local:N", "tcp://"],
    "bifurcation --scheduler local:0": ["--scheduler local:N", "= 0"],
    "bifurcation --scheduler local:x": ["--scheduler local:N", "'x'"],
    "bifurcation --scheduler tcp://here": ["'tcp://here'", "8786"],
    "bifurcation --scheduler tcp://here:99999": ["tcp://here:99999"],
    "bifurcation scan.toml -o scan.toml --overwrite": ["scan.toml"],
    "bifurcation scan.toml -o hard.h5 --overwrite": ["another file of this run"],
    "bifurcation /dev/zero": ["/dev/zero", "no regular file"],
    # sizes and ranges
    "bifurcation --periods 1000000000": ["GB of memory", "fewer periods"],
    "bifurcation --periods 1000000000 --dry-run": ["GB of memory"],
    "bifurcation --vary P=1:2:9999 --vary C=0.1:0.2:9999 --periods 99999": ["GB", "free"],
    "bifurcation --start random:1000000 --vary P=1:2:9999": ["orbits"],
    "bifurcation --vary P=1:2:10000000 --vary C=0.1:0.2:10000000": [
        "10000000 x 10000000 = 100000000000000 cells", "up to 100000000",
    ],
    "bifurcation --vary P=1:2:10000000 --vary C=0:1:9 --start random:1000": ["90000000000 orbits"],
    "bifurcation --vary omega=1e308:1.7e308:2 --plot x.png": [
        "--plot 'x.png'", "omega = 1e+308", "1e+300",
    ],
    "bifurcation --vary P=5e-324:1e-323:2 --plot x.png": ["P = 5e-324", "1e-300"],
    "portrait --set V=1e308": ["obstacle at 1e+308 m"],
    "tuning --over P=1,2 --over m1=1,2 --band 5:6:100000000": ["400000000 cases"],
    "tuning --free C=0:1e308 --free k2 --surface C,k2 --plot x.png": [
        "C = 1e+308", "cannot be drawn",
    ],
    # other tasks
    "response-curves --system tmd --vary C=0:1:3": ["C"],
    "response-curves --vary omega=5:8": ["--vary omega = '5:8' must be START:STOP:NUM"],
    "response-curves --start random:4": ["--start"],
    "response-curves curves.toml": ["label", "null"],
    "response-curves scan.toml -o scan.toml": ["must end in .h5"],
    "portrait column.toml": ["name", "null"],
    "portrait --windows 1:5,4:9": ["1:5", "4:9", "follow"],
    "portrait --windows 1:5 --periods 3": ["windows", "periods"],
    "portrait --windows 1:2,3:4,5:6,7:8,9:10": ["columns = 5"],
    "portrait --windows 0:1_0": ["windows", "'0:1_0'", "BEGIN:END"],
    "portrait --start 0,0,0": ["start", "x1, v1, x2, v2"],
    "portrait --start up": ["--start", "'up'"],
    "portrait --strat -0.03": ["'--start'"],
    "portrait --start ٠,0,0,0": ["--start", "0 to 9"],
    "portrait --periods 100000": ["100600", "10000000"],
    "portrait --periods 5 --comb 6": ["comb = 6", "5"],
    "portrait --signal x3": ["'x3'", "x1"],
    "portrait --system none --signal x2": ["'x2'", "'none'"],
    "portrait --panel force": ["--panel", "--panels"],
    "tuning --free k2=5": ["--free k2 = '5' must be LOW:HIGH"],
    "tuning --free k2=a:b": ["--free k2 = 'a' must be a number"],
    "tuning --free k2=1_0:20": ["--free k2", "without _"],
    "tuning --free k2 --free k2=1:2": ["given twice"],
    "tuning --free omega": ["unknown free parameter 'omega'"],
    "tuning --band 5:8": ["--band = '5:8' must be LOW:HIGH:NUM"],
    "tuning --band 5:8:x": ["--band = 'x' must be a whole number"],
    "tuning --band 8:5:3": ["start = 8.0 must not be greater"],
    "tuning --band 5:8:3 --over omega=5,6": ["exclude each other"],
    "tuning --over P=1,x": ["--over P = 'x' must be a number"],
    "tuning --over P=1_0": ["--over P", "without _"],
    "tuning --system none": ["no damper"],
    "continuation --along omega=5": ["--along 'omega=5' must be NAME=START:STOP"],
    "continuation --along omega=5:x": ["--along omega"],
    "continuation --along omega=9:5": ["the first must be the lesser"],
    "continuation --along x=5:9": ["unknown parameter 'x'"],
    "continuation --along m2=-1:5": ["m2 = -1.0 is not allowed"],
    "continuation --plane omega=5:9": ["omega is free already"],
    "continuation --plane P=100:200": ["must hold the system's own value"],
    "continuation --from none.h5": ["there is no such file"],
    "continuation --over none.h5": ["there is no such file"],
    "continuation --system tmd --along C=1:2": ["C is no parameter of kind 'tmd'"],
    "transients --starts 0": ["count = 0"],
    "transients --starts 1000000 --periods 1000000": ["begin fewer orbits"],
    "transients --seed -1": ["seed = -1"],
    "transients --transient -1": ["transient = -1"],
    "transients --effort much": ["'much'"],
    "transients --tolerance 1e-20": ["command line", "tolerance = 1e-20; allowed: 1e-13 to 0.001"],
    "transients --tolerance drft": ["tolerance = 'drft'; allowed: 1e-13 to 0.001, or draft"],
    "transients --tolerance 1_0": ["--tolerance", "without _"],
    "transients --delay -3": ["delay = -3.0"],
    "transients --delay nan": ["delay"],
    "transients --delay 1_0": ["--delay", "without _"],
    "transients --start up": ["'--start'"],
    "accuracy --want much": ["--want", "much"],
    "accuracy --want 0": ["--want"],
    "accuracy --want nan": ["--want"],
    "accuracy --periods 1": ["--periods"],
    "accuracy --periods 100000000": ["--periods"],
    "accuracy --periods 2_0": ["--periods", "without _"],
    "accuracy scan.toml --system tmd": ["scan.toml", "--system tmd"],
    "accuracy own.toml": ["own.toml"],
    "accuracy scan.toml --plot scan.toml": ["another file of this run"],
    "explore no.h5": ["no.h5"],
    "explore --port 70000": ["--port"],
    "explore map.h5 --set P=3": ["--set"],
    # upkeep
    "rerun": ["required", "FILE.h5"],
    "rerun no.h5": ["'no.h5'", "no such file"],
    "rerun old.h5": ["old.h5", "no HDF5 file"],
    "rerun pipe.toml": ["pipe.toml", "no such file"],
    "rerun old.h5 --threads 0": ["threads = 0"],
    "rerun old.h5 -o old.h5 --overwrite": ["old.h5"],
    f"rerun old.h5 -o {ODD}.h5": ["not UTF-8"],
    "report no.h5": ["no.h5"],
    "report folder": ["no regular file"],
    "report map.h5 -o map.h5": ["is another file of this run"],
    "report map.h5 -o no/x.html": ["no folder"],
}  # fmt: skip


@pytest.fixture(scope="module")
def archive(tmp_path_factory):
    """The bytes of a map that nobody computed."""
    path = tmp_path_factory.mktemp("map") / "map.h5"
    return write(path, make_scan(("energy", "regime"), vary=MAP)).read_bytes()


@pytest.fixture
def folder(archive, here):
    """A working folder with a good scan, a map, and things that are in the way."""
    (here / "scan.toml").write_text(GOOD)
    (here / "curves.toml").write_text(GOOD + '[[curves]]\nlabel = "a\\u0000b"\n')
    column = 'system = "tmd"\n[[column]]\nname = "a\\u0000b"\nwindow = [0, 2]\n'
    (here / "column.toml").write_text(column)
    (here / "map.h5").write_bytes(archive)
    (here / "old.h5").write_bytes(b"precious")
    (here / "link.h5").symlink_to("nowhere")
    (here / "nowhere.h5").symlink_to("no/x.h5")
    os.link(here / "scan.toml", here / "hard.h5")
    os.mkfifo(here / "pipe.toml")
    for name in ("folder", "folder.png", "folder.toml", "empty.h5.parts"):
        (here / name).mkdir()
    for name in ("loop.h5", "loop.toml", "loop.png"):
        (here / name).symlink_to(name)
    for name in ("piped", "folded", "typed", "nested"):
        (here / f"{name}.h5.parts").mkdir()
    os.mkfifo(here / "piped.h5.parts" / "manifest.json")
    (here / "folded.h5.parts" / "manifest.json").mkdir()
    words = {"title": 1, "scan_hash": "", "toml": 3, "argv": [], "began": ""}
    durable.write(here / "typed.h5.parts" / "manifest.json", json.dumps(words).encode())
    durable.write(here / "nested.h5.parts" / "manifest.json", b"[" * 100_000)
    with socket.socket(socket.AF_UNIX) as server:
        server.bind("socket.toml")
        yield here


@pytest.fixture(autouse=True)
def nothing_is_computed(monkeypatch):
    def run(*_, **__):
        raise AssertionError("a faulty request has reached the kernels")

    for name in (
        "bifurcation.run", "tuning.run", "portrait.run", "loads.run", "accuracy.measure",
    ):  # fmt: skip
        fake = ModuleType(f"nlds_vines.{name}")
        vars(fake).update(run=run, views_of=run)
        monkeypatch.setitem(sys.modules, fake.__name__, fake)


def assert_one_line(status, out, err, named):
    assert status == 2
    assert out == ""
    assert err.count("\n") == 1
    assert "Traceback" not in err
    assert printable(err[:-1]) == err[:-1]
    for word in named:
        assert word in err


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
    lacks = SOME_LACK - set(re.findall(r"(?<![\w-])--?[a-z]+", capsys.readouterr().out))
    lines = {line: shlex.split(line) for line in SHARED}
    tried = [line for line, words in lines.items() if not lacks & set(words)]
    assert len(tried) > len(SHARED) / 2
    for line in tried:
        refused([command, *NEEDED.get(command, []), *lines[line]], SHARED[line])


@pytest.mark.parametrize("command", READERS)
def test_a_file_that_cannot_be_read(command, refused):
    for line, named in UNREADABLE.items():
        refused([command, *shlex.split(line)], named)


@pytest.mark.parametrize("line", LINES, ids=lambda line: line[:50])
def test_a_faulty_command_line(line, refused):
    refused(shlex.split(line), LINES[line])


def test_the_good_file_reaches_the_kernels(folder):
    # or else every file above could be refused for a reason that is none
    for more in ([], ["-o", "old.h5", "--resume"]):
        with pytest.raises(AssertionError, match="reached the kernels"):
            main(["bifurcation", "scan.toml", *more])


@pytest.mark.parametrize("line", ["--system tdm", "--set P=nan", "-o old.h5"])
def test_the_process_answers_likewise(line, folder):
    before = contents(folder)
    done = python("-W", "error", "-m", "nlds_vines.bifurcation", *shlex.split(line))
    assert_one_line(done.returncode, done.stdout, done.stderr, SHARED[line])
    assert contents(folder) == before
