"""What is compiled beside, what is said of it, and that nothing is left of it."""

import contextlib
import os
import re
import signal
import subprocess
import sys
import threading
import time

import pytest

from nlds_vines.engine import compilation
from nlds_vines.engine.batch import LANES
from nlds_vines.engine.compilation import Compilation, Needed, kernels_of
from nlds_vines.errors import RequestError
from nlds_vines.kernels.cells import lanes
from nlds_vines.kernels.numerics import compiling, elementary
from nlds_vines.runs import executors, interrupts, progress

USUAL = Needed("ssul", "exact", ("section", "impacts", "energy", "regime"))


@pytest.fixture
def begun(monkeypatch):
    """Let there be two processors and memory; return what is begun beside: processes that sleep."""
    processes = []

    def begin(needed):
        process = subprocess.Popen(
            [sys.executable, "-c", "import sys; sys.stdin.read()"],
            stdin=subprocess.PIPE, stdout=subprocess.PIPE, start_new_session=True,
        )  # fmt: skip
        processes.append((needed, process))
        return process

    monkeypatch.setattr(compilation, "processors", lambda: 2)
    monkeypatch.setattr(compilation, "threads_in_use", lambda: 2)
    monkeypatch.setattr(compilation, "free_memory", lambda: 10**10)
    monkeypatch.setattr(compilation, "begin", begin)
    yield processes
    for _, process in processes:
        assert process.poll() is not None  # nothing is left
        process.kill()


def follow(*kernels, needed=USUAL, helped=True):
    """Return the messages while kernels are compiled in one block."""
    messages = []
    follower = Compilation(needed, lambda text, seconds: messages.append(text), helped)
    with follower.followed(LANES):
        for kernel in kernels:
            compiled(kernel)
    return messages


def compiled(kernel):
    """Announce a compiled kernel to whatever follows compilations."""
    with compiling._watch.compiling(kernel):
        pass


def words(seconds):
    """Return the message about so many seconds; empty if nothing is compiled."""
    return [
        "compiling the equations of ssul into machine code, which is kept for later runs: "
        f"about {seconds} s",
        "",
    ]


def test_what_is_compiled_here_or_beside_is_said_once(begun):
    assert kernels_of(["section"]) == kernels_of(["energy", "peak"]) == ("orbit",)
    assert kernels_of(["section", "lyapunov"]) == ("orbit", "verdict")
    assert follow(lanes.run_lanes, lanes.judge_lanes, helped=False) == words(24)
    assert follow(lanes.judge_lanes) == words(12)
    alone = USUAL._replace(want=("energy",))
    assert follow(lanes.run_lanes, needed=alone) == words(12)
    assert follow(elementary.exp) == []
    assert begun == []
    assert follow(lanes.run_lanes, elementary.exp) == words(12)
    ((needed, _),) = begun
    assert needed == USUAL


def test_the_kernels_of_hosts_take_longer(begun):
    needed = Needed("a host", "exact", ("regime",))
    messages = follow(lanes.run_lanes, needed=needed, helped=False)
    assert messages[0].endswith("about 60 s")


def test_the_estimate_corrects_itself_by_the_pace_of_this_machine(begun):
    follower = Compilation(USUAL, None, helped=False)
    with follower.followed(LANES):
        compiled(lanes.run_lanes)
        assert follower._words(0.0).endswith("about 24 s")
        for _ in range(99):
            compiled(elementary.exp)
        usual = 100 * compilation.EACH
        assert follower._words(usual).endswith(f"about {24 - usual:.0f} s to go")
        assert follower._words(3 * usual).endswith(f"about {3 * (24 - usual):.0f} s to go")
        assert follower._words(1e4 * usual).endswith("s to go")
    # the time of compiling is known
    before = Compilation.waited
    with Compilation(USUAL, None, helped=False).followed(LANES):
        compiled(lanes.run_lanes)
        time.sleep(0.05)
    assert Compilation.waited - before >= 0.05
    before = Compilation.waited
    assert follow(helped=False) == []
    assert Compilation.waited == before


ALONE = {
    "processors": 1, "threads_in_use": 1, "free_memory": compilation.MEMORY + 1,
    "multiprocessing.parent_process": object(),  # one of a pool
}  # fmt: skip


@pytest.mark.parametrize("name", ALONE)
def test_nobody_helps_where_it_would_not_help(begun, monkeypatch, name):
    assert compilation.may_help()
    monkeypatch.setattr(f"nlds_vines.engine.compilation.{name}", lambda: ALONE[name])
    assert not compilation.may_help()
    assert follow(lanes.run_lanes) == words(24)
    assert begun == []


def test_memory_that_does_not_suffice_is_one_line(begun, monkeypatch):
    monkeypatch.setattr(compilation, "free_memory", lambda: 300_000_000)
    with pytest.raises(RequestError, match=r"takes 700 MB of memory, 300 MB are free"):
        follow(lanes.run_lanes)
    assert follow(elementary.exp) == []
    monkeypatch.setattr(compilation, "free_memory", lambda: None)  # unknown: nothing is refused
    assert len(follow(lanes.run_lanes)) == 2


@pytest.mark.parametrize("error", [KeyboardInterrupt, MemoryError])
def test_no_process_outlives_what_it_was_begun_for(begun, error):
    def struck():
        follower = Compilation(USUAL, None, True)
        with follower.followed(LANES):
            compiled(lanes.run_lanes)
            assert begun[0][1].poll() is None
            raise error

    with pytest.raises(error):
        struck()


def test_a_signal_ends_compiling_at_the_next_function(begun):
    messages = []
    follower = Compilation(USUAL, lambda *what: messages.append(what[0]), False)

    def run():
        with interrupts.stop_on_signals() as stop, follower.followed(LANES):
            compiled(lanes.run_lanes)
            stop.handle(signal.SIGINT, None)
            compiled(elementary.exp)

    with pytest.raises(interrupts.Stopped):
        run()
    assert messages[-1] == ""
    with Compilation(USUAL, None, False).followed(LANES):
        compiled(elementary.exp)  # outside the block nothing is asked


@pytest.mark.parametrize("longest", [0.1, 60.0])
def test_the_verdict_is_awaited_until_it_is_there_but_not_for_ever(begun, monkeypatch, longest):
    monkeypatch.setattr(compilation, "LONGEST", longest)
    follower = Compilation(USUAL, None, True)
    follower.await_verdict()  # nothing was begun
    with follower.followed(LANES):
        compiled(lanes.run_lanes)
        ((_, process),) = begun
        if longest > 1.0:
            threading.Timer(0.3, process.terminate).start()
        follower.await_verdict()
        assert (process.poll() is not None) == (longest > 1.0)


def test_while_something_is_compiled_the_seconds_are_told(monkeypatch):
    monkeypatch.setattr(progress, "TICK", 0.01)
    messages, enough = [], threading.Event()

    def tell(text, seconds):
        messages.append((text, seconds))
        if len(messages) > 4:
            enough.set()

    with Compilation(USUAL, tell, False).followed(LANES):
        compiled(lanes.run_lanes)
        assert enough.wait(60)
    estimates = [seconds for text, seconds in messages if re.search(r"about \d+ s( to go)?$", text)]
    assert len(estimates) > 3
    assert estimates == sorted(estimates)
    assert messages[-1][0] == ""
    assert estimates[-1] <= messages[-1][1]


def test_what_runs_after_compiling_does_not_count_as_compiling():
    messages = []
    follower = Compilation(USUAL, lambda text, seconds: messages.append(text), False)
    with follower.followed({lanes.run_lanes: "orbit"}):
        compiled(lanes.judge_lanes)
        assert messages == []
        compiled(lanes.run_lanes)
        assert messages[-1] == ""
        count = len(messages)
    assert len(messages) == count


def test_in_python_it_is_said_too_unless_asked_not_to(monkeypatch, capsys):
    tell = compilation.notice()
    for seconds in (0.0, 1.0, 2.0, 5.5, 6.0):
        tell(f"compiling, {9 - seconds} s to go", seconds)
    tell("", 7.0)
    assert capsys.readouterr() == ("", "compiling, 9.0 s to go\n")  # where there is no terminal
    assert compilation.notice(quiet=True) is None
    with compilation.silent(True), compilation.silent(False):
        assert compilation.notice() is None
    with compilation.silent(False):
        assert compilation.notice() is not None
    monkeypatch.setattr(compilation.multiprocessing, "parent_process", lambda: object())
    assert compilation.notice() is None


def test_a_process_that_fails_ends_and_where_none_can_be_begun_there_is_none(monkeypatch):
    process = compilation.begin(USUAL._replace(scene="no such kind"))
    assert process.wait(60) == 1
    process.communicate()
    monkeypatch.setattr(sys, "executable", "/no/such/python")
    assert compilation.begin(USUAL) is None


@pytest.mark.kernels
def test_a_process_ends_with_whoever_began_it(monkeypatch, tmp_path):
    """Its standard input ends when this process does, even by SIGKILL."""
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path))  # empty: it has long to compile
    monkeypatch.setenv("NUMBA_DISABLE_JIT", "0")
    process = compilation.begin(USUAL)
    with contextlib.suppress(subprocess.TimeoutExpired):
        process.wait(2.0)
    assert process.poll() is None
    assert os.getpgid(process.pid) != os.getpgid(0)  # Ctrl-C in the terminal is not for it
    process.stdin.close()
    assert process.wait(60) == 1


def test_threads_are_those_of_the_run():
    executors.use_threads(1)
    try:
        assert not compilation.may_help()
    finally:
        executors.use_threads(None)
