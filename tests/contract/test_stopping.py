"""Ctrl-C and SIGTERM: each task ends within two seconds, also in a compiled loop, and says so."""

import array
import fcntl
import os
import signal
import termios
import threading
import time
from dataclasses import replace
from pathlib import Path

import pytest
from commands import printed, python, started
from made_up import content, cut, make_scan, results, write

from nlds_vines.__main__ import main as console
from nlds_vines.bifurcation.run import plan_of
from nlds_vines.cli.terminal import exit_status_of
from nlds_vines.runs import interrupts
from nlds_vines.runs.executors import in_pieces
from nlds_vines.runs.interrupts import Interrupted, Stopped, stop_on_signals, stoppable
from nlds_vines.runs.run_options import RunOptions
from nlds_vines.runs.store import BlockStore, publish
from nlds_vines.scans.run import writer_of
from scans import stored

WITHIN = 4.0
"""Seconds; two where the processors are idle."""

LONG = 10**8
"""Forcing periods, which take minutes."""


def cpu_seconds(process):
    """Return the processor time [s] that a process has used, in all its threads."""
    fields = Path(f"/proc/{process.pid}/stat").read_text("ascii").rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def has_printed(process):
    """Return True if a process has printed what nobody has read."""
    count = array.array("i", [0])
    fcntl.ioctl(process.stdout, termios.FIONREAD, count)
    return count[0] > 0


def has_a_thread(process):
    """Return True if a process works in a thread beside its first one (`stoppable`)."""
    return len(os.listdir(f"/proc/{process.pid}/task")) > 1


def begun(arguments, folder, until=lambda process: True):
    """Start Python with these arguments; return the process when it computes.

    That is when `until(process)` holds and it has used two seconds of processor time since.
    """
    process = started(*arguments, cwd=folder, OPENBLAS_NUM_THREADS="1")  # starts no threads
    last, since = time.monotonic() + 120, None
    while since is None or cpu_seconds(process) < since + 2.0:
        time.sleep(0.05)
        assert process.poll() is None, process.communicate()
        assert time.monotonic() < last
        if since is None and until(process):
            since = cpu_seconds(process)
    return process


CHAOS = "--set omega=7.385"  # where no state returns: settled orbits are copied, not run
SCAN = "--vary omega=7.384:7.385:4 --record section --threads 2 --transient"
TMD = "--system tmd --vary omega=5:8:9"

TASKS = {
    "portrait": (
        f"{CHAOS} --windows {LONG}:{LONG + 20} --plot long.png",
        f"{CHAOS} --windows 20:40 --plot short.png",
    ),
    "bifurcation": (f"{SCAN} {LONG}", f"{SCAN} 10"),
    "response-curves": (
        f"{TMD} --transient {LONG} --plot long.png", f"{TMD} --transient 10 --plot short.png",
    ),
    "response-history": (
        "--vary impulse=100:1000:20000 --duration 2000", "--vary impulse=100:1000:2 --duration 2",
    ),
    "transients": (f"--starts 4 --transient {LONG}", "--starts 4 --transient 1"),
    "tuning": ("--band 4.5:8:500 --transient 100000", None),
    "tuning under a load": ("--impulse 1000 --duration 20000", None),
    "continuation": (
        "--plane P=300:1500 --doublings 8 --step 0.001 --all", "--along omega=6.2:6.3",
    ),
    "accuracy": ("--periods 10000", None),
    "explore": ("--port 0 --no-browser scan.toml", None),
}  # fmt: skip
"""Options of a task that takes minutes; of a short one that compiles the same, or None: it ends
while it compiles, or later."""

SLOW_SCAN = f"""
system = "ssul-set6"
vary.omega.values = [7.3, 7.4, 7.5]
vary.P.values = [600.0, 700.0, 800.0]
sampling.transient = {LONG}
"""

KEEPS_NOTHING = {
    "accuracy": "what was measured is lost", "explore": "what it computes is not kept",
}  # fmt: skip
"""What tasks without an archive say."""

TERMINATED = ("bifurcation", "explore")
"""Tasks that SIGTERM ends, too: one with an archive, one without."""


@pytest.mark.kernels
@pytest.mark.parametrize(
    ("task", "number"),
    [*((task, signal.SIGINT) for task in TASKS), *((task, signal.SIGTERM) for task in TERMINATED)],
)
def test_a_task_ends_within_two_seconds(task, number, here):
    long, short = TASKS[task]
    name = task.split()[0]
    if short is not None:  # in this process, which may have loaded its kernels
        assert console([name, *short.split(), "-o", "short.h5", "--quiet"]) in (0, 1)
    (here / "scan.toml").write_text(SLOW_SCAN, "utf-8")
    output = [] if task in KEEPS_NOTHING else ["-o", "long.h5"]
    until = has_printed if task == "explore" else has_a_thread
    process = begun(["-m", "nlds_vines", name, *long.split(), *output], here, until)
    began = time.monotonic()
    process.send_signal(number)
    try:
        out, err = process.communicate(timeout=60)
    finally:
        process.kill()
    assert time.monotonic() - began < WITHIN
    assert "Traceback" not in err
    assert process.returncode == (130 if number == signal.SIGINT else 143)
    assert KEEPS_NOTHING.get(task, "kept in long.h5.") in out + err
    assert not (here / "long.h5").exists()


PYTHON = """
import sys
import nlds_vines as nv
system = nv.load_system("ssul-set6", omega=7.385)  # chaos, where no state returns
axis = dict(omega=dict(values=[7.384, 7.385]))
short, long = {short}, {long}
work = lambda many: {call}
work(short)
open("begun", "w").close()
try:
    work(long)
except KeyboardInterrupt as stop:
    print("interrupted", *stop.args, flush=True)
print(nv.simulate(system, 2, quiet=True).state.tolist(), file=sys.stderr)
"""

CALLS = {
    "simulate": "nv.simulate(system, 1, transient=many, quiet=True)",
    "scan": "nv.scan(system, vary=axis, sampling={'transient': many}, quiet=True)",
    "classify": "nv.classify(system, transient=many, quiet=True)",
    "portrait": "nv.orbit_portrait(system, windows=[[many, many + 20]], quiet=True)",
    "response_history": "nv.response_history(system, load={'impulse': 1e3}, sampling="
    "{'duration': min(many, 2000.0)}, vary={'C': {'start': 0.02, 'stop': 0.1, 'num': "
    "min(many, 20_000)}}, quiet=True)",
    "tune": "nv.tune(load={'impulse': 1e3}, sampling={'duration': min(many, 20_000.0)}, "
    "search=dict(population=min(many, 200), generations=1, polish=0, optima=1), quiet=True)",
    "continue_branch": "nv.continue_branch('ssul-set6', 'omega', (6.2, 6.3) if many < 1000 "
    "else (5, 9), start='random', step=1e-3, doublings=8, quiet=True)",
}
"""What is called, of so many forcing periods."""

RUNS = ("scan", "response_history", "tune", "continue_branch")
"""Those that would keep blocks in an archive, if one were named."""


@pytest.mark.kernels
@pytest.mark.parametrize("call", CALLS)
def test_ctrl_c_ends_a_call_in_python_and_the_session_goes_on(call, tmp_path):
    program = PYTHON.format(short=100, long=LONG, call=CALLS[call])
    process = begun(["-c", program], tmp_path, lambda process: (tmp_path / "begun").exists())
    began = time.monotonic()
    process.send_signal(signal.SIGINT)
    line = process.stdout.readline()
    took = time.monotonic() - began
    out, err = process.communicate(timeout=120)
    lost = " interrupted: what was computed is lost, because no archive was named (to=)"
    assert line == f"interrupted{lost if call in RUNS else ''}\n"
    assert took < WITHIN
    *others, state = err.splitlines()
    assert (process.returncode, out, state[0]) == (0, "", "["), err
    assert all(line.startswith("stopping: ") for line in others)


ABANDONED = """
import ctypes, os, signal, sys, threading, time
from nlds_vines.runs import interrupts
from nlds_vines.runs.interrupts import stoppable
libc = ctypes.CDLL(None)
libc.on_exit(libc.abort, None)
threading.Timer(0.1, os.kill, (os.getpid(), signal.SIGINT)).start()
try:
    stoppable(time.sleep)(float(sys.argv[1]))
except KeyboardInterrupt:
    pass
time.sleep(0.3)
print("said")
interrupts.exit_status = 7  # as a command does
sys.exit(7)
"""


@pytest.mark.parametrize(("seconds", "status"), [(60.0, 7), (0.2, -signal.SIGABRT)])
def test_c_functions_at_exit_are_skipped_where_an_abandoned_thread_is_alive(seconds, status):
    # LLVM's destructors, while it compiles: half of these processes crashed
    done = python("-c", ABANDONED, seconds)
    assert done.returncode == status, done.stderr
    assert done.stdout == "said\n"


COMPILING = """
import os, signal, sys, threading, time
from nlds_vines.kernels.numerics.compiling import global_compiler_lock
from nlds_vines.runs.interrupts import stoppable

def compiling():
    with global_compiler_lock:
        time.sleep(1.0)
        open("compiled", "w").close()
    time.sleep(60.0)

threading.Timer(0.1, os.kill, (os.getpid(), signal.SIGINT)).start()
try:
    stoppable(compiling)()
except KeyboardInterrupt:
    sys.exit(7)
"""


def test_a_program_in_python_ends_when_nothing_is_being_compiled(tmp_path):
    began = time.monotonic()
    done = python("-c", COMPILING, cwd=tmp_path)
    assert done.returncode == 7, done.stderr
    assert (tmp_path / "compiled").exists()
    assert time.monotonic() - began < 30


# ---- the mechanism -------------------------------------------------------------------------------


def asked(seconds, number):
    threading.Timer(seconds, os.kill, (os.getpid(), number)).start()


@stoppable
def sleeping(seconds):
    time.sleep(seconds)
    return seconds


@stoppable
def waiting(over):
    over.wait(60.0)


@stoppable
def busy(over):
    until = time.monotonic() + 60.0
    while time.monotonic() < until and not over.is_set():
        time.sleep(0.01)


@pytest.fixture
def over():
    """Return an event with which abandoned work ends, at the end of the test."""
    event = threading.Event()
    yield event
    event.set()


@pytest.mark.parametrize("work", [waiting, busy])
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_what_is_under_way_is_abandoned_after_its_time(over, number, work, monkeypatch, capfd):
    """In C, and in Python that never asks; a minute is its end if nothing abandons it."""
    monkeypatch.setattr(interrupts, "GRACE", 0.3)
    began = time.monotonic()
    asked(0.1, number)
    with pytest.raises(Stopped), stop_on_signals():
        work(over)
    assert 0.4 <= time.monotonic() - began < 30.0
    assert "a second" in capfd.readouterr().err


def test_an_abandoned_thread_ends_at_its_next_check():
    steps = []

    @stoppable
    def work():
        for step in range(600):
            interrupts.check()
            steps.append(step)
            time.sleep(0.1)

    asked(0.15, signal.SIGINT)
    with pytest.raises(KeyboardInterrupt):
        work()
    count = len(steps)
    time.sleep(0.5)
    assert len(steps) <= count + 1


@pytest.mark.parametrize(
    ("number", "grace", "seconds"), [(signal.SIGINT, 30.0, 0.25), (signal.SIGUSR1, 0.3, 1.0)]
)
def test_what_ends_in_time_is_not_lost_and_notice_by_sigusr1_lets_it_end(
    number, grace, seconds, monkeypatch, capfd
):
    monkeypatch.setattr(interrupts, "GRACE", grace)
    ended = []

    def run():
        with stop_on_signals():
            assert sleeping(seconds) == seconds
            with pytest.raises(Stopped):
                interrupts.check()
            time.sleep(0.5)  # what is put away after a stop is not stopped again
            ended.append(True)

    asked(0.1, number)
    with pytest.raises(Stopped):
        run()
    assert ended
    assert ("finished first" in capfd.readouterr().err) == (number == signal.SIGUSR1)


def ask_now(number):
    """Send a signal to this process, and wait until the run that takes signals has it."""
    os.kill(os.getpid(), number)
    while not any(stop.asked for stop in interrupts._taking):
        time.sleep(0.001)


@pytest.mark.parametrize(("number", "status"), [(signal.SIGINT, 130), (signal.SIGTERM, 143)])
@pytest.mark.parametrize("moment", ["last work", "while written", "in its place", "at the end"])
def test_a_signal_before_the_end_of_a_run_is_never_lost(
    moment, number, status, tmp_path, monkeypatch, capfd
):
    """Only a run whose archive was in its place leaves one; all say what is there."""
    path, scan = tmp_path / "scan.h5", make_scan()
    whole = content(write(tmp_path / "whole.h5", scan))
    store = BlockStore(path, scan)
    plan = replace(plan_of(scan), blocks=cut(scan))

    def work():
        for block in plan.blocks:
            store.save(block.index, stored(scan, results(scan, block)))
        if moment == "last work":
            ask_now(number)
        write = writer_of(plan, store)

        def write_and_ask(target):
            write(target)
            if moment == "while written":
                ask_now(number)

        return write_and_ask

    def asking(function):
        def asked_after(*arguments):
            function(*arguments)
            ask_now(number)

        return asked_after

    if moment == "in its place":
        monkeypatch.setattr("nlds_vines.runs.store.publish", asking(publish))
    if moment == "at the end":
        monkeypatch.setattr(store, "_remove", asking(store._remove))
    with pytest.raises(Interrupted) as interrupted:
        store.carry_out(RunOptions(), work)
    assert interrupted.value.status == status
    assert "stopping: " in capfd.readouterr().err
    assert [*interrupts._taking] == []
    if moment in ("last work", "while written"):
        assert "3 blocks are kept in " in str(interrupted.value)
        assert not path.exists()
        assert store.carry_out(RunOptions(resume=True), lambda: writer_of(plan, store))
    else:
        assert str(interrupted.value) == f"interrupted: {path} is complete"
    assert content(path) == whole


class Deaf:
    """An object whose destructor is at work when a signal comes."""

    def __init__(self, number):
        self.number = number

    def __del__(self):
        os.kill(os.getpid(), self.number)


@pytest.mark.parametrize(("number", "status"), [(signal.SIGINT, 130), (signal.SIGTERM, 143)])
@pytest.mark.parametrize("is_swallowed", [False, True])
def test_a_signal_ends_a_command_in_one_line_also_in_a_destructor(
    is_swallowed, number, status, capsys
):
    """In the program and in its command, of which each takes signals."""
    before = [signal.getsignal(one) for one in (signal.SIGINT, signal.SIGTERM)]

    def work():
        if not is_swallowed:
            os.kill(os.getpid(), number)
        one = Deaf(number)
        del one
        return 0

    assert exit_status_of("", lambda: exit_status_of("plot", work)) == status
    assert capsys.readouterr().err == "nlds-vines plot: interrupted\n"
    assert exit_status_of("plot", lambda: 0) == 0
    assert [signal.getsignal(one) for one in (signal.SIGINT, signal.SIGTERM)] == before


@pytest.mark.parametrize(("number", "status"), [(signal.SIGINT, 130), (signal.SIGTERM, 143)])
def test_a_signal_that_a_destructor_swallows_is_sent_again(number, status, capsys):
    """The command does not go on to its end."""

    def work():
        one = Deaf(number)
        del one
        time.sleep(60.0)
        return 0

    began = time.monotonic()
    assert exit_status_of("plot", work) == status
    assert time.monotonic() - began < 30.0
    assert capsys.readouterr().err == "nlds-vines plot: interrupted\n"


@pytest.mark.parametrize(("number", "status"), [(signal.SIGINT, 130), (signal.SIGTERM, 143)])
def test_an_error_that_a_library_makes_of_a_signal_is_the_signal(number, status, capsys):
    """As h5py does, which ends in a SystemError."""

    def work():
        try:
            os.kill(os.getpid(), number)
        except KeyboardInterrupt:
            raise SystemError("returned a result with an exception set") from None

    assert exit_status_of("", lambda: exit_status_of("plot", work)) == status
    assert capsys.readouterr().err == "nlds-vines plot: interrupted\n"
    with pytest.raises(SystemError):
        exit_status_of("plot", lambda: (_ for _ in ()).throw(SystemError("its own")))


LOADING = """
import os, runpy, signal, sys

class Finder:
    def find_spec(name, path, target=None):
        if name == {name!r}:
            os.kill(os.getpid(), signal.{number})

sys.meta_path.insert(0, Finder)
sys.argv = ["program", *{words!r}]
runpy.run_module({module!r}, run_name="__main__", alter_sys=True)
"""


@pytest.mark.parametrize(
    ("name", "number", "status"),
    [
        ("nlds_vines.cli.terminal", "SIGINT", 130), ("nlds_vines.errors", "SIGINT", 130),
        ("numpy", "SIGINT", 130), ("numpy", "SIGTERM", 143),
    ],
)  # fmt: skip
@pytest.mark.parametrize(
    ("module", "words"), [("nlds_vines", ["tuning", "--dry-run"]), ("nlds_vines.tuning", [])]
)
def test_a_signal_while_a_program_loads_its_modules_ends_it_in_one_line(
    module, words, name, number, status
):
    program = LOADING.format(name=name, number=number, module=module, words=words)
    done = python("-c", program)
    assert (done.returncode, done.stdout) == (status, "")
    assert done.stderr in ("nlds-vines: interrupted\n", "nlds-vines tuning: interrupted\n")


INTERRUPTED_IN_A_TEXT = """
from nlds_vines.cli.entry import run
raise SystemExit(run(lambda: exec("import os, signal; os.kill(os.getpid(), signal.SIGINT)")))
"""


def test_ctrl_c_while_python_carries_out_a_text_ends_with_our_status(here):
    """As a data class is made so, each import has such moments; Python would end by SIGINT."""
    (here / "program.py").write_text(INTERRUPTED_IN_A_TEXT, "utf-8")
    done = python("-m", "program", cwd=here)
    assert (done.returncode, done.stderr) == (130, "nlds-vines: interrupted\n")


def test_what_is_loaded_before_a_program_takes_signals_is_next_to_nothing():
    """Until then Python answers Ctrl-C with a traceback."""
    program = (
        "import sys; before = {*sys.modules}; import nlds_vines.cli.entry, nlds_vines.__main__;"
        "print(*sorted({*sys.modules} - before))"
    )
    heavy = {"re", "enum", "typing", "pathlib", "signal", "threading", "argparse", "numpy"}
    assert not heavy & {*printed("-S", "-c", program).split()}


OVER = """
import os, signal, sys
from nlds_vines.runs import interrupts
print("done")
interrupts.end_with(1)
os.kill(os.getpid(), signal.{number})
sys.exit(3)
"""

ENDING = """
import os, signal, sys
from nlds_vines.runs import interrupts

class Last:  # what Python destroys at its very end
    def __del__(self, kill=os.kill, number=signal.{number}, process=os.getpid()):
        kill(process, number)

last = Last()
print("done")
interrupts.end_with(1)
sys.exit(1)
"""


@pytest.mark.parametrize("number", ["SIGINT", "SIGTERM"])
def test_a_signal_after_the_work_of_a_command_changes_neither_its_status_nor_its_lines(number):
    for program in (OVER, ENDING):
        done = python("-c", program.format(number=number))
        assert (done.returncode, done.stdout, done.stderr) == (1, "done\n", "")


def test_ctrl_c_where_no_run_takes_it_is_python_s(over):
    began = time.monotonic()
    asked(0.1, signal.SIGINT)
    with pytest.raises(KeyboardInterrupt):
        waiting(over)
    assert time.monotonic() - began < 30.0


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
    divided = stoppable(lambda a, *, by: a / by)
    assert divided(1, by=4) == 0.25
    with pytest.raises(ZeroDivisionError):
        divided(1, by=0)
