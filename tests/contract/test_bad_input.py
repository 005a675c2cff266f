"""Whatever is wrong with a request: status 2, one line that names it, and nothing left behind."""

import re
import subprocess
import sys
from pathlib import Path
from types import ModuleType

import pytest

import nlds_vines
from nlds_vines.__main__ import main as console
from nlds_vines.bifurcation.command import bifurcation, main
from nlds_vines.errors import RequestError

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


def without(line: str) -> str:
    """The good file without the line that begins like this."""
    return "\n".join(each for each in GOOD.splitlines() if not each.startswith(line))


def table(name: str, content: str) -> str:
    """The good file with one table's content replaced or added."""
    tables = re.split(r"^(?=\[)", GOOD, flags=re.MULTILINE)
    others = [each for each in tables if not each.startswith(f"[{name}]")]
    return "".join(others) + f"[{name}]\n{content}\n"


def system(content: str) -> str:
    return without("system") + f"\n[system]\n{content}\n"


def vary(content: str) -> str:
    return table("vary", content)


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
    "unknown key of start": (table("start", 'polcy = "rest"'), ["'polcy'", "'policy'"]),
    "unknown key of sampling": (table("sampling", "period = 3"), ["[sampling]", "'periods'"]),
    "unknown key of record": (table("record", 'wnat = ["section"]'), ["[record]", "'want'"]),
    "unknown key of system": (system(NONE + "omgea = 2\n"), ["[system]", "'omgea'", "'omega'"]),
    # system
    "no system": (without("system"), ["scan.toml", "no system", "tmd"]),
    "unknown system": (GOOD.replace("set6", "set7"), ["'ssul-set7'", "'ssul-set6'"]),
    "system is a number": (GOOD.replace('"ssul-set6"', "6"), ["system = 6", "[system] table"]),
    "system without kind": (system("m1 = 1"), ["[system]", "kind is missing", "ssul"]),
    "unknown kind": (system('kind = "sssul"'), ["'sssul'", "'ssul'"]),
    "kind is a list": (system("kind = []"), ["kind", "[]", "ssul"]),
    "missing parameter": (system(NONE), ["[system]", "missing: omega"]),
    "foreign parameter": (system(NONE + "omega = 1\nk2 = 1\n"), ["'none'", "'k2'"]),
    "parameters are no table": (system('kind = "tmd"\nparameters = 3'), ["parameters = 3"]),
    "parameter in two places": (
        system(NONE + "omega = 1\n[system.parameters]\nm1 = 2"),
        ["m1", "[system.parameters]"],
    ),
    "source is no text": (system(NONE + "omega = 1\nsources = { m1 = 3 }"), ["sources.m1 = 3"]),
    # set
    "unknown parameter": (table("set", "mass = 3"), ["[set]", "'mass'", "m1"]),
    "parameter of another kind": (table("set", "D = 3"), ["[set]", "'D'", "'ssul'"]),
    "negative mass": (table("set", "m1 = -3"), ["[set]", "m1 = -3.0", "> 0"]),
    "zero frequency": (
        vary("P = { values = [1] }\n[set]\nomega = 0"),
        ["[set]", "omega = 0.0", "> 0"],
    ),
    "Poisson's ratio": (table("set", "nu1 = 0.7"), ["nu1 = 0.7", "0.5"]),
    "NaN": (table("set", "C = nan"), ["[set]", "C = nan", "finite"]),
    "infinity": (table("set", "k1 = -inf"), ["[set]", "k1 = -inf", "finite"]),
    "huge integer": (table("set", "k1 = 1" + "0" * 400), ["k1 = 1000", "finite"]),
    "text for a number": (table("set", 'P = "800"'), ["P = '800'", "number"]),
    "bool for a number": (table("set", "P = true"), ["P = True", "number"]),
    "date for a number": (table("set", "P = 2020-01-01"), ["P = ", "number"]),
    "set is no table": ("set = 3\n" + GOOD, ["[set]", "set = 3", "table"]),
    "K beside a modulus": (table("set", "K = 1e7\nE1 = 1e9"), ["[set]", "K beside E1"]),
    "A and B zero": (table("set", "A = 0\nB = 0"), ["A + B must be > 0"]),
    "set and varied": (table("set", "omega = 6"), ["[set]", "omega", "[vary]"]),
    # vary
    "nothing varied": (without("omega"), ["scan.toml", "[vary]", "none"]),
    "three axes": (
        vary("P = { values = [1] }\nC = { values = [1] }\nV = { values = [1] }"),
        ["[vary]", "P, C, V", "two"],
    ),
    "unknown axis": (vary("omga = { values = [1] }"), ["[vary]", "'omga'", "'omega'"]),
    "axis is a list": (vary("omega = [1, 2]"), ["[vary] omega", "[1, 2]", "table"]),
    "axis is empty": (vary("omega = {}"), ["[vary] omega", "nothing given", "values"]),
    "range without num": (vary("omega = { start = 1, stop = 2 }"), ["omega", "start, stop", "num"]),
    "range and values": (
        vary("omega = { start = 1, stop = 2, num = 3, values = [1] }"),
        ["omega", "values alone"],
    ),
    "start > stop": (
        vary("omega = { start = 8, stop = 5, num = 9 }"),
        ["[vary] omega", "start = 8.0", "stop = 5.0"],
    ),
    "start = stop": (vary("omega = { start = 5, stop = 5, num = 2 }"), ["omega", "5.0", "once"]),
    "num = 0": (vary("omega = { start = 5, stop = 8, num = 0 }"), ["omega", "num = 0", "1"]),
    "num absurd": (
        vary("omega = { start = 5, stop = 8, num = 10000001 }"),
        ["num = 10000001", "10000000"],
    ),
    "num not whole": (vary("omega = { start = 5, stop = 8, num = 3.0 }"), ["num = 3.0", "whole"]),
    "num is a bool": (vary("omega = { start = 5, stop = 8, num = true }"), ["num = True", "whole"]),
    "NaN in a range": (vary("omega = { start = nan, stop = 8, num = 3 }"), ["start = nan"]),
    "overflowing range": (vary("C = { start = -1.7e308, stop = 1.7e308, num = 3 }"), ["C", "nan"]),
    "no values": (vary("omega = { values = [] }"), ["omega", "0 values", "1"]),
    "equal values": (vary("omega = { values = [5, 6, 5] }"), ["omega", "5.0", "more than once"]),
    "values are a number": (vary("omega = { values = 5 }"), ["omega", "values = 5", "list"]),
    "values are text": (vary('omega = { values = "56" }'), ["omega", "values = '56'", "list"]),
    "infinite value": (vary("omega = { values = [5, inf] }"), ["omega = inf", "finite"]),
    "bool among values": (vary("omega = { values = [5, true] }"), ["omega = True", "number"]),
    "varied out of range": (vary("m2 = { start = -1, stop = 1, num = 3 }"), ["m2 = -1.0", "> 0"]),
    # start, sampling, record, title
    "unknown policy": (table("start", 'policy = "rset"'), ["[start]", "'rset'", "'rest'"]),
    "count zero": (table("start", 'policy = "random"\ncount = 0'), ["[start]", "count = 0"]),
    "seed negative": (table("start", 'policy = "random"\nseed = -1'), ["[start]", "seed = -1"]),
    "count without random": (table("start", "count = 3"), ["[start]", "'random'", "'rest'"]),
    "start is a word": ('start = "rest"\n' + GOOD, ["[start]", "'rest'", "table"]),
    "zero periods": (table("sampling", "periods = 0"), ["[sampling]", "periods = 0", "from 1"]),
    "negative transient": (table("sampling", "transient = -1"), ["transient = -1", "from 0"]),
    "periods not whole": (table("sampling", "periods = 1.5"), ["periods = 1.5", "whole"]),
    "unknown method": (table("sampling", 'method = "ode23s"'), ["'ode23s'", "exact, rk4"]),
    "empty request": (table("record", "want = []"), ["[record]", "empty request", "section"]),
    "want is a word": (table("record", 'want = "section"'), ["[record]", "'section'", "list"]),
    "unknown want": (table("record", 'want = ["enery"]'), ["[record]", "'enery'", "'energy'"]),
    "want a number": (table("record", "want = [3]"), ["[record]", "unknown want 3"]),
    "want something twice": (table("record", 'want = ["energy", "energy"]'), ["twice"]),
    "impacts without walls": (
        table("record", 'want = ["impacts"]').replace("ssul-set6", "tmd"),
        ["[record]", "'impacts'", "'tmd'", "energy"],
    ),
    "title is a number": (GOOD.replace('"good"', "8"), ["scan.toml", "title = 8", "string"]),
}

# what is wrong on the command line -> what the line must name
COMMAND_LINES = {
    "unknown option": (["--dry-ru"], ["'--dry-ru'", "'--dry-run'"]),
    "abbreviated option": (["--over"], ["'--over'", "--overwrite"]),
    "two scans": (["scan.toml", "other.toml"], ["too many", "other.toml"]),
    "no such scan": (["nothing.toml"], ["nothing.toml", "No such file"]),
    "scan is a folder": (["folder"], ["folder", "Is a directory"]),
    "unknown system": (["--system", "tdm"], ["--system", "'tdm'", "'tmd'"]),
    "no such system file": (["--system", "no.toml"], ["--system", "no.toml"]),
    "set without value": (["--set", "P"], ["--set 'P'", "NAME=VALUE"]),
    "set with empty value": (["--set", "P="], ["--set 'P='", "NAME=VALUE"]),
    "set to text": (["--set", "P=many"], ["--set P", "'many'", "number"]),
    "set to NaN": (["--set", "P=nan"], ["command line", "P = nan", "finite"]),
    "set twice": (["--set", "P=1", "--set", "P=2"], ["--set P", "twice", "1 and 2"]),
    "set unknown": (["--set", "mass=1"], ["command line: [set]", "'mass'", "m1"]),
    "set negative mass": (["--set", "m1=-1"], ["command line: [set]", "m1 = -1.0"]),
    "set what is varied": (["--set", "omega=6"], ["omega", "figure8.toml: [vary]"]),
    "set and vary": (["--set", "P=1", "--vary", "P=1:2:3"], ["P", "command line: [vary]"]),
    "vary without range": (["--vary", "omega"], ["--vary 'omega'", "START:STOP:NUM"]),
    "vary half a range": (["--vary", "omega=5:8"], ["--vary omega", "'5:8'", "START:STOP:NUM"]),
    "vary text": (["--vary", "omega=a:8:3"], ["--vary omega", "'a'", "number"]),
    "vary a fraction": (["--vary", "omega=5:8:3.5"], ["--vary omega", "'3.5'", "whole"]),
    "vary downwards": (["--vary", "omega=8:5:3"], ["omega", "start = 8.0", "stop = 5.0"]),
    "vary nothing": (["--vary", "omega=5:8:0"], ["omega", "num = 0"]),
    "vary twice the same": (["--vary", "P=1:2:3", "--vary", "P=1:2:4"], ["--vary P", "twice"]),
    "vary three": (
        ["--vary", "P=1:2:3", "--vary", "C=1:2:3", "--vary", "V=1:2:3"],
        ["P, C, V", "two"],
    ),
    "unknown policy": (["--start", "uo"], ["[start]", "'uo'", "'up'"]),
    "random without number": (["--start", "random"], ["--start random:N", "''", "whole"]),
    "random nothing": (["--start", "random:0"], ["count = 0"]),
    "up with a number": (["--start", "up:3"], ["'up:3'", "'up'"]),
    "transient in words": (["--transient", "ten"], ["--transient", "'ten'"]),
    "transient negative": (["--transient", "-1"], ["transient = -1"]),
    "periods zero": (["--periods", "0"], ["periods = 0"]),
    "record nothing": (["--record", ""], ["empty request"]),
    "record unknown": (["--record", "section,enrgy"], ["'enrgy'", "'energy'"]),
    "record impacts of a TMD": (["--system", "tmd", "--record", "impacts"], ["'impacts'", "'tmd'"]),
    "unknown method": (["--method", "rk5"], ["'rk5'", "'rk4'"]),
    "no threads": (["--threads", "0"], ["threads = 0"]),
    "resume and overwrite": (["--resume", "--overwrite"], ["--resume", "--overwrite"]),
    "option without value": (["--plot"], ["--plot", "one argument"]),
    "output is a folder": (["-o", "folder"], ["'folder'", "is a folder"]),
    "output is no archive": (["-o", "a.csv"], ["'a.csv'", "must end in .h5"]),
    "output is a picture": (["-o", "a.png"], ["'a.png'", "must end in .h5"]),
    "output in no folder": (["-o", "no/x.h5"], ["'no/x.h5'", "'no'"]),
    "output below a file": (["-o", "old.h5/x.h5"], ["old.h5"]),
    "output not writable": (["-o", "/proc/x.h5"], ["/proc/x.h5", "cannot be written"]),
    "output name too long": (["-o", "x" * 300], ["xxx", "too long"]),
    "output exists": (["-o", "old.h5"], ["'old.h5' exists", "--resume", "--overwrite"]),
    "output is a broken link": (["-o", "link.h5"], ["'link.h5' exists"]),
    "output is the scan": (["scan.toml", "-o", "scan.toml", "--overwrite"], ["scan.toml"]),
    "output is the picture": (["-o", "x.png", "--plot", "x.png"], ["x.png"]),
    "plot of unknown kind": (["--plot", "x.gif"], ["'x.gif'", ".png, .pdf, .svg"]),
    "plot of nothing": (
        ["--vary", "P=1:2:5", "--vary", "C=1:2:5", "--record", "section", "--plot", "x.png"],
        ["--plot 'x.png'", "energy or regime"],
    ),
    "plot in no folder": (["--plot", "no/x.png"], ["'no/x.png'", "'no'"]),
    "plot is a folder": (["--plot", "folder.png"], ["'folder.png'", "is a folder"]),
    "shard in words": (["--shard", "third"], ["--shard 'third'", "i/n", "slurm"]),
    "shard zero": (["--shard", "0/7"], ["--shard '0/7'", "from 1 to n"]),
    "shard beyond": (["--shard", "8/7"], ["--shard '8/7'", "from 1 to n"]),
    "shard of too many": (["--shard", "1/99999"], ["--shard '1/99999'", "10000"]),
    "shard of no array": (["--shard", "slurm"], ["SLURM_ARRAY_TASK_ID", "job array"]),
    "shard and overwrite": (["--shard", "1/7", "--overwrite"], ["--shard", "--overwrite"]),
    "shard and scheduler": (["--shard", "1/7", "--scheduler", "local:2"], ["--scheduler"]),
    "shard and plot": (["--shard", "1/7", "--plot", "x.png"], ["--plot 'x.png'", "consolidate"]),
    "scheduler in words": (["--scheduler", "dask"], ["--scheduler 'dask'", "local:N", "tcp://"]),
    "scheduler of none": (["--scheduler", "local:0"], ["--scheduler local:N", "= 0"]),
    "scheduler of many": (["--scheduler", "local:x"], ["--scheduler local:N", "'x'"]),
    "scheduler without port": (["--scheduler", "tcp://here"], ["'tcp://here'", "8786"]),
    "a path for a system": (["--system", "../../etc/passwd"], ["../../etc/passwd"]),
    "threads absurd": (["--threads", "100000"], ["threads = 100000", "4096"]),
    "a block of 32 GB": (["--periods", "1000000000"], ["GB of memory", "fewer periods"]),
    "more than any disk": (
        ["--vary", "P=1:2:9999", "--vary", "C=0.1:0.2:9999", "--periods", "99999"],
        ["GB", "free"],
    ),
    "a dry run of it": (["--periods", "1000000000", "--dry-run"], ["GB of memory"]),
    "too many starts": (["--start", "random:1000000", "--vary", "P=1:2:9999"], ["orbits"]),
}

# the sister commands: what is wrong -> what the line must name
SISTERS = {
    "verify nothing": (["verify"], ["required", "FILE"]),
    "verify what is not there": (["verify", "no.h5"], ["'no.h5'", "no such file"]),
    "verify a folder of none": (["verify", "folder"], ["'folder'", "without parts"]),
    "verify with an unknown option": (["verify", "old.h5", "--quit"], ["'--quit'", "'--quiet'"]),
    "consolidate nothing": (["consolidate"], ["required", "FILE.h5"]),
    "consolidate without parts": (["consolidate", "old.h5"], ["'old.h5'", "no parts"]),
    "consolidate an empty folder": (["consolidate", "empty.h5"], ["empty.h5", "no parts"]),
    "consolidate two": (["consolidate", "a.h5", "b.h5"], ["too many", "b.h5"]),
    "status of nothing": (["status", "no.h5"], ["'no.h5'", "no such archive"]),
    "status of an empty folder": (["status", "empty.h5"], ["empty.h5", "nothing was begun"]),
    "status of no archive": (["status", "old.h5"], ["old.h5", "no HDF5 file"]),
    "rerun nothing": (["rerun"], ["required", "FILE.h5"]),
    "rerun what is not there": (["rerun", "no.h5"], ["'no.h5'", "no such file"]),
    "rerun no archive": (["rerun", "old.h5"], ["old.h5", "no HDF5 file"]),
    "rerun on no threads": (["rerun", "old.h5", "--threads", "0"], ["threads = 0"]),
    "rerun onto itself": (["rerun", "old.h5", "-o", "old.h5", "--overwrite"], ["old.h5"]),
    "diff of one": (["diff", "old.h5"], ["required", "B.h5"]),
    "diff with nothing": (["diff", "old.h5", "no.h5"], ["'no.h5'", "no such file"]),
    "diff of no archives": (["diff", "old.h5", "scan.toml"], ["old.h5", "no HDF5 file"]),
}


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """A working folder with a good scan and things that are in the way."""
    (tmp_path / "scan.toml").write_text(GOOD)
    (tmp_path / "old.h5").write_bytes(b"precious")
    (tmp_path / "link.h5").symlink_to("nowhere")
    (tmp_path / "folder").mkdir()
    (tmp_path / "folder.png").mkdir()
    (tmp_path / "empty.h5.parts").mkdir()
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.fixture(autouse=True)
def _nothing_is_computed(monkeypatch):
    def run(*_, **__):
        raise AssertionError("a faulty request has reached the kernels")

    for name in ("run", "estimate"):
        fake = ModuleType(f"nlds_vines.bifurcation.{name}")
        setattr(fake, name, run)
        monkeypatch.setitem(sys.modules, fake.__name__, fake)


def everything(folder: Path) -> dict[str, bytes | None]:
    """All names below a folder, with the bytes of the files."""
    return {
        str(path.relative_to(folder)): path.read_bytes() if path.is_file() else None
        for path in folder.rglob("*")
    }


def assert_one_line(
    status: int, out: str, err: str, named: list[str], command: str = "bifurcation"
) -> None:
    assert status == 2
    assert out == ""
    assert err.endswith("\n")
    assert err.count("\n") == 1
    assert err.startswith(f"nlds-vines {command}: error: ")
    assert "Traceback" not in err
    for word in named:
        assert word in err


@pytest.mark.parametrize("case", FILES)
def test_faulty_files(case, folder, capsys):
    content, named = FILES[case]
    data = content if isinstance(content, bytes) else content.encode()
    (folder / "scan.toml").write_bytes(data)
    before = everything(folder)
    assert_one_line(main(["scan.toml"]), *capsys.readouterr(), named)
    assert everything(folder) == before


@pytest.mark.parametrize("case", COMMAND_LINES)
def test_faulty_command_lines(case, folder, capsys):
    arguments, named = COMMAND_LINES[case]
    before = everything(folder)
    assert_one_line(main(arguments), *capsys.readouterr(), named)
    assert everything(folder) == before


@pytest.mark.parametrize("case", SISTERS)
def test_faulty_sister_commands(case, folder, capsys):
    arguments, named = SISTERS[case]
    before = everything(folder)
    assert_one_line(console(arguments), *capsys.readouterr(), named, arguments[0])
    assert everything(folder) == before


def test_the_good_file_reaches_the_kernels(folder):
    # or else every file above could be refused for a reason that is none
    with pytest.raises(AssertionError, match="reached the kernels"):
        main(["scan.toml"])
    with pytest.raises(AssertionError, match="reached the kernels"):
        main(["scan.toml", "-o", "old.h5", "--resume"])


def test_odd_characters_stay_on_one_line(folder, capsys):
    assert_one_line(main(["a\nb\r\u2028c.toml"]), *capsys.readouterr(), ["a b c.toml"])
    assert_one_line(main(["--set", "m\n1=2"]), *capsys.readouterr(), ["unknown parameter"])
    assert_one_line(main(["-o", "a\0b"]), *capsys.readouterr(), ["null"])


@pytest.mark.parametrize("case", ["unknown system", "set to NaN", "output exists", "two scans"])
def test_the_process_answers_likewise(case, folder):
    arguments, named = COMMAND_LINES[case]
    before = everything(folder)
    done = subprocess.run(
        [sys.executable, "-W", "error", "-m", "nlds_vines.bifurcation", *arguments],
        capture_output=True,
        text=True,
        env={"PYTHONPATH": str(Path(nlds_vines.__path__[0]).parent)},
        check=False,
    )
    assert_one_line(done.returncode, done.stdout, done.stderr, named)
    assert everything(folder) == before


def test_the_console_script_passes_the_request_on(folder, capsys):
    assert_one_line(console(["bifurcation", "--set", "P"]), *capsys.readouterr(), ["--set 'P'"])


def test_the_console_script_knows_its_commands(capsys):
    assert console(["bifurcate"]) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert err.count("\n") == 1
    assert "unknown command 'bifurcate'; did you mean 'bifurcation'?" in err


def test_the_function_refuses_as_the_command_does(folder):
    before = everything(folder)
    with pytest.raises(RequestError, match=r"old\.h5' exists"):
        bifurcation("scan.toml", "old.h5")
    with pytest.raises(RequestError, match="exclude each other"):
        bifurcation("scan.toml", resume=True, overwrite=True)
    with pytest.raises(RequestError, match="threads = 0"):
        bifurcation("scan.toml", threads=0)
    with pytest.raises(RequestError, match="scan = 3 must be"):
        bifurcation(3)
    assert everything(folder) == before
