"""Ctrl-C and SIGTERM: each task ends within two seconds, also in a compiled loop, and says so."""

import os
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path

import pytest

import nlds_vines
from nlds_vines.runs import interrupts
from nlds_vines.runs.interrupts import Stopped, stop_on_signals, stoppable
from nlds_vines.runs.pool import in_pieces

ROOT = Path(nlds_vines.__path__[0]).parent

WITHIN = 4.0
"""Seconds; two where the processors are idle."""

LONG = 10**8
"""Forcing periods, which take minutes."""


def begun(arguments, folder, until):
    """Start Python with these arguments, and return the process a while after `until()` holds."""
    process = subprocess.Popen(
        [sys.executable, *map(str, arguments)],
        stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
        text=True, cwd=folder, env={**os.environ, "PYTHONPATH": str(ROOT)},
    )  # fmt: skip
    last = time.monotonic() + 120
    while not until() and process.poll() is None and time.monotonic() < last:
        time.sleep(0.05)
    time.sleep(2.0)  # it is in a compiled loop by now, if all is compiled
    assert process.poll() is None, process.communicate()
    return process


def ended(process, number):
    """Send a signal; return (exit status, what is said), within two seconds."""
    began = time.monotonic()
    process.send_signal(number)
    try:
        out, err = process.communicate(timeout=60)
    finally:
        process.kill()
    assert time.monotonic() - began < WITHIN
    assert "Traceback" not in err
    return process.returncode, out + err


SCAN = ["--record", "section", "--threads", "2"]

TASKS = {
    "portrait": (
        ["--windows", f"{LONG}:{LONG + 20}", "--plot", "long.png"],
        ["--windows", "20:40", "--plot", "short.png"],
    ),
    "bifurcation": (
        ["--vary", "omega=7.3:7.4:4", "--transient", LONG, *SCAN],
        ["--vary", "omega=7.3:7.4:4", "--transient", 10, *SCAN],
    ),
    "response-curves": (
        ["--system", "tmd", "--vary", "omega=5:8:9", "--transient", LONG, "--plot", "long.png"],
        ["--system", "tmd", "--vary", "omega=5:8:9", "--transient", 10, "--plot", "short.png"],
    ),
    "response-history": (
        ["--vary", "impulse=100:1000:20000", "--duration", 2000],
        ["--vary", "impulse=100:1000:2", "--duration", 2],
    ),
    "transients": (["--starts", 4, "--transient", LONG], ["--starts", 4, "--transient", 1]),
    "tuning": (["--band", "4.5:8:500", "--transient", 100_000], None),
}
"""Options of a task that takes minutes; of a short one that compiles the same, or None: it ends
while it compiles, or later."""


@pytest.mark.kernels
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
@pytest.mark.parametrize("task", TASKS)
def test_a_task_ends_within_two_seconds(task, number, tmp_path):
    long, short = TASKS[task]
    words = ["-m", "nlds_vines", task]
    if short is not None:
        done = subprocess.run(
            [sys.executable, *words, *map(str, short), "-o", "short.h5"], cwd=tmp_path,
            env={**os.environ, "PYTHONPATH": str(ROOT)}, capture_output=True, check=False,
        )  # fmt: skip
        assert done.returncode in (0, 1), done.stderr
    parts = tmp_path / "long.h5.parts"
    process = begun([*words, *long, "-o", "long.h5"], tmp_path, parts.exists)
    status, said = ended(process, number)
    assert status == (130 if number == signal.SIGINT else 143)
    assert "kept in long.h5.parts" in said
    assert not (tmp_path / "long.h5").exists()


PYTHON = """
import nlds_vines as nv
from nlds_vines.runs.interrupts import Interrupted
system, axis = nv.load_system("ssul-set6"), dict(omega=dict(values=[7.3, 7.4]))
short, long = {short}, {long}
work = lambda many: {call}
work(short)
open("begun", "w").close()
try:
    work(long)
except (KeyboardInterrupt, Interrupted):
    print("interrupted", flush=True)
print(nv.simulate(system, 2, quiet=True).state.tolist())
"""

CALLS = {
    "simulate": "nv.simulate(system, 1, transient=many, quiet=True)",
    "scan": "nv.scan(system, vary=axis, sampling={'transient': many}, quiet=True)",
    "classify": "nv.classify(system, transient=many, quiet=True)",
    "portrait": "nv.orbit_portrait(system, windows=[[many, many + 20]], quiet=True)",
}
"""What is called, of so many forcing periods."""


@pytest.mark.kernels
@pytest.mark.parametrize("call", CALLS)
def test_ctrl_c_ends_a_call_in_python_and_the_session_goes_on(call, tmp_path):
    program = PYTHON.format(short=100, long=LONG, call=CALLS[call])
    process = begun(["-c", program], tmp_path, (tmp_path / "begun").exists)
    began = time.monotonic()
    process.send_signal(signal.SIGINT)
    assert process.stdout.readline() == "interrupted\n"
    assert time.monotonic() - began < WITHIN
    out, err = process.communicate(timeout=120)
    assert (process.returncode, out.startswith("[")) == (0, True), err


# ---- the mechanism -------------------------------------------------------------------------------


def asked(seconds, number):
    """Send this process a signal after so many seconds."""
    threading.Timer(seconds, os.kill, (os.getpid(), number)).start()


@stoppable
def sleeping(seconds):
    time.sleep(seconds)
    return seconds


@pytest.fixture
def soon(monkeypatch):
    """Let what is under way have less time."""
    monkeypatch.setattr(interrupts, "GRACE", 0.3)


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_what_is_under_way_is_abandoned_after_its_time(soon, number, capfd):
    began = time.monotonic()
    asked(0.1, number)
    with stop_on_signals(), pytest.raises(Stopped):
        sleeping(5.0)
    assert 0.4 <= time.monotonic() - began < 2.0
    assert "a second" in capfd.readouterr().err


def test_what_ends_in_time_is_not_lost(soon, capfd):
    asked(0.1, signal.SIGINT)
    with stop_on_signals() as stop:
        assert sleeping(0.25) == 0.25
        assert stop.asked


def test_notice_by_sigusr1_lets_a_block_end(soon, capfd):
    asked(0.1, signal.SIGUSR1)
    with stop_on_signals() as stop:
        assert sleeping(1.0) == 1.0
        with pytest.raises(Stopped):
            stop.check()
    assert "finished first" in capfd.readouterr().err


def test_ctrl_c_where_no_run_takes_it_is_python_s():
    began = time.monotonic()
    asked(0.1, signal.SIGINT)
    with pytest.raises(KeyboardInterrupt):
        sleeping(5.0)
    assert time.monotonic() - began < 1.0


def test_no_piece_is_begun_of_work_that_is_abandoned():
    begun = []

    def work(begin, end):
        begun.append(begin)
        time.sleep(0.05)

    @stoppable
    def pieces():
        in_pieces(work, 1000, 1, 1)

    asked(0.2, signal.SIGINT)
    with pytest.raises(KeyboardInterrupt):
        pieces()
    count = len(begun)
    time.sleep(0.3)
    assert len(begun) <= count + 1


def test_results_and_errors_are_those_of_the_work():
    @stoppable
    def divided(a, *, by):
        return a / by

    assert divided(1, by=4) == 0.25
    with pytest.raises(ZeroDivisionError):
        divided(1, by=0)
