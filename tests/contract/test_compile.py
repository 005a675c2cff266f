"""What a run does with what it finds, or does not find, in the cache of compiled kernels."""

import os
import signal
import subprocess
import sys
import time
from contextlib import suppress
from pathlib import Path

import numba
import pytest
from commands import printed

import nlds_vines as nv

ROOT = str(Path(nv.__path__[0]).parent)


def program(folder, *arguments, **changes):
    environment = {**os.environ, "PYTHONPATH": ROOT, "NUMBA_DISABLE_JIT": "0"}
    environment |= {"NUMBA_CACHE_DIR": str(folder / "cache"), **changes}
    pipe = subprocess.PIPE
    return subprocess.Popen(
        [sys.executable, "-m", "nlds_vines", *arguments],
        cwd=folder, env=environment, stdout=pipe, stderr=pipe, text=True,
    )  # fmt: skip


def finished(folder, *arguments, **changes):
    process = program(folder, *arguments, **changes)
    out, err = process.communicate(timeout=BOUND)
    return process.returncode, out, err


@pytest.mark.kernels
@pytest.mark.parametrize("task", [
    "response-history --system none",
    "tuning --system tmd --free k2=1000:1500 --generations 1 --polish 1",
])  # fmt: skip
def test_what_is_compiled_under_a_load_is_said(tmp_path, task):
    struck = ["--impulse", "1000", "--duration", "20", "-o", "a.h5"]
    status, _, err = finished(tmp_path, *task.split(), *struck)
    assert status == 0, err
    assert f"compiling the equations of {task.split()[2]} into machine code" in err


@pytest.mark.kernels
def test_a_run_finds_what_was_compiled_and_says_what_was_not(tmp_path):
    scan = ["bifurcation", "--system", "none", "--vary", "omega=6:7:2", "--record", "section"]
    scan += ["--transient", "1", "--periods", "2", "--overwrite", "-o", "a.h5"]
    words = (
        "compiling the equations of none into machine code, which is kept for later runs: "
        "about 12 s\n"
    )
    status, _, err = finished(tmp_path, *scan)
    assert status == 0
    assert err.startswith(words)
    status, _, err = finished(tmp_path, *scan)
    assert (status, err) == (0, "")
    status, _, err = finished(tmp_path, *scan, "--quiet", NUMBA_OPT="2")
    assert (status, err) == (0, "")


@pytest.mark.kernels
@pytest.mark.skipif(numba.config.DISABLE_JIT, reason="nothing is compiled")
def test_what_is_compiled_for_branches_is_what_a_continuation_calls(tmp_path):
    """In a process of its own, whose second half would compile what the first has left out."""
    program = """
from nlds_vines.continuation.section_map import KERNELS, SectionMap
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
    assert printed("-c", program, NUMBA_CACHE_DIR=str(tmp_path)) == "[]\n"


def children(pid):
    """Return the processes in which the threads of a process have begun to compile."""
    words = []
    with suppress(FileNotFoundError):  # of a thread, or a process, that ends meanwhile
        for task in Path(f"/proc/{pid}/task").iterdir():
            listed = task / "children"
            if listed.parent.is_dir() and not listed.exists():
                pytest.skip("the system does not show them")
            words += listed.read_text().split()
    return [int(word) for word in words if b"compile_verdict" in command_of(word)]


def command_of(pid):
    try:
        return Path(f"/proc/{pid}/cmdline").read_bytes()
    except OSError:
        return b""


def alive(pid):
    try:
        os.kill(pid, 0)
    except ProcessLookupError:
        return False
    return Path(f"/proc/{pid}/stat").read_text().split(")")[1].split()[0] != "Z"


def awaited(happens, process):
    """Wait until something happens, as long as a process lives; return it."""
    while process.poll() is None:
        if result := happens():
            return result
        time.sleep(0.02)
    return happens()


BOUND = 300
"""Seconds after which a process that should end at once is taken for one that does not end."""


@pytest.mark.parametrize("end", [signal.SIGINT, signal.SIGKILL])
def test_nothing_goes_on_after_the_end(end, tmp_path):
    process = program(tmp_path, "bifurcation")
    started = awaited(lambda: children(process.pid), process)
    assert started
    assert not list(tmp_path.rglob("lanes.*.compiled"))
    process.send_signal(end)
    _, err = process.communicate(timeout=BOUND)
    if end == signal.SIGINT:
        assert process.returncode == 130
        assert "interrupted: 0 of " in err
    while any(alive(child) for child in started):
        time.sleep(0.02)
    assert not list(tmp_path.rglob("lanes.*.compiled"))  # none was compiled to its end


def test_ctrl_c_is_answered_while_a_run_compiles(tmp_path):
    process = program(tmp_path, "bifurcation", "--threads", "1")
    first = process.stderr.readline()
    assert first.startswith("compiling the equations of ssul")
    process.send_signal(signal.SIGINT)
    _, err = process.communicate(timeout=BOUND)
    assert process.returncode == 130
    assert "interrupted: 0 of " in err
    assert not list(tmp_path.rglob("lanes.*.compiled"))
