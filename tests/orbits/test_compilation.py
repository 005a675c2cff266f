"""What is compiled elsewhere meanwhile, what is said of it, and that nothing is left of it."""

import contextlib
import os
import subprocess
import sys
import time

import pytest

from nlds_vines.errors import RequestError
from nlds_vines.kernels import compiling, elementary, lanes
from nlds_vines.orbits import compilation, elsewhere
from nlds_vines.orbits.compilation import Compilation
from nlds_vines.orbits.elsewhere import Needed, kernels_of
from nlds_vines.runs import progress, threads

USUAL = Needed("ssul", "exact", ("section", "impacts", "energy", "regime"))


def test_which_kernels_a_record_needs():
    assert kernels_of(["section"]) == kernels_of(["energy", "peak"]) == ("orbit",)
    assert kernels_of(["section", "lyapunov"]) == ("orbit", "verdict")
    assert kernels_of(["error"]) == ("orbit", "error")
    assert kernels_of(["error", "regime"]) == ("orbit", "verdict", "error")


class Begun(list):
    """Stands in for `elsewhere.begin`: processes that sleep."""

    def __call__(self, kernels, needed, *, writes):
        assert not writes
        sleep = "import sys; sys.stdin.read()"
        process = subprocess.Popen(
            [sys.executable, "-c", sleep],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            start_new_session=True,
        )
        self.append((tuple(kernels), needed, process))
        return process


@pytest.fixture
def begun(monkeypatch):
    """Let there be two processors and memory; return what is begun elsewhere."""
    monkeypatch.setattr(elsewhere, "processors", lambda: 2)
    monkeypatch.setattr(elsewhere, "threads_in_use", lambda: 2)
    monkeypatch.setattr(elsewhere, "free_memory", lambda: 10**10)
    monkeypatch.setattr(elsewhere, "begin", processes := Begun())
    yield processes
    for _, _, process in processes:
        assert process.poll() is not None  # nothing is left
        process.kill()


def follow(*kernels, needed=USUAL, helped=True):
    """Return what is said when kernels are about to be compiled."""
    said = []
    follower = Compilation(needed, lambda text, seconds: said.append(text), helped)
    with follower.followed():
        for kernel in kernels:
            compiled(kernel)
    return said


def compiled(kernel):
    """Tell what follows compilations that a kernel is compiled."""
    compiling._watch.told[-1](kernel)
    compiling._watch.ended[-1](kernel)


def words(count, seconds):
    """Return what is said of a kernel; an empty text when it is there."""
    return [
        "compiling the kernels of ssul (once for this kind and these records, about "
        f"{seconds} s; {count})",
        "",
    ]


def test_the_verdict_is_compiled_elsewhere_and_all_is_said_once(begun):
    said = follow(lanes.run_lanes, elementary.exp)
    assert said == words("1 of 2: orbit", 18)
    ((kernels, needed, _),) = begun
    assert kernels == ("verdict",)
    assert needed == USUAL


def test_what_is_compiled_here_is_said_too(begun):
    said = follow(lanes.run_lanes, lanes.judge_lanes, helped=False)
    assert said == words("1 of 2: orbit", 30) + words("2 of 2: verdict", 30)
    assert follow(lanes.judge_lanes) == words("1 of 1: verdict", 18)
    alone = USUAL._replace(want=("energy",))
    assert follow(lanes.run_lanes, needed=alone) == words("1 of 1: orbit", 12)
    assert follow(elementary.exp) == []
    assert begun == []


ALONE = {
    "one processor": ("processors", lambda: 1),
    "one thread": ("threads_in_use", lambda: 1),
    "little memory": ("free_memory", lambda: elsewhere.MEMORY + 1),
}


@pytest.mark.parametrize("reason", ALONE)
def test_nobody_helps_where_it_would_not_help(begun, monkeypatch, reason):
    assert elsewhere.may_help()
    monkeypatch.setattr(elsewhere, *ALONE[reason])
    assert not elsewhere.may_help()
    assert follow(lanes.run_lanes) == words("1 of 2: orbit", 30)
    assert begun == []


def test_nobody_helps_a_process_of_a_pool(begun, monkeypatch):
    monkeypatch.setattr(elsewhere.multiprocessing, "parent_process", lambda: object())
    assert not elsewhere.may_help()


def test_memory_that_does_not_suffice_is_one_line(begun, monkeypatch):
    monkeypatch.setattr(elsewhere, "free_memory", lambda: 300_000_000)
    with pytest.raises(RequestError, match=r"takes 1 GB of memory, 0.3 GB are free"):
        follow(lanes.run_lanes)
    assert follow(elementary.exp) == []
    monkeypatch.setattr(elsewhere, "free_memory", lambda: None)  # unknown: nothing is refused
    assert len(follow(lanes.run_lanes)) == 2


@pytest.mark.parametrize("error", [KeyboardInterrupt, MemoryError])
def test_no_process_outlives_what_it_was_begun_for(begun, error):
    def struck():
        follower = Compilation(USUAL, None, True)
        with follower.followed():
            compiled(lanes.run_lanes)
            assert begun[0][2].poll() is None
            raise error

    with pytest.raises(error):
        struck()


def test_the_verdict_is_awaited_but_not_for_ever(begun, monkeypatch):
    monkeypatch.setattr(compilation, "LONGEST", 0.1)
    follower = Compilation(USUAL, None, True)
    follower.await_verdict()  # nothing was begun
    with follower.followed():
        compiled(lanes.run_lanes)
        began = time.perf_counter()
        follower.await_verdict()
        assert time.perf_counter() - began < 5.0
        assert begun[0][2].poll() is not None
        follower.await_verdict()


def test_while_something_is_waited_for_the_seconds_are_told(begun, monkeypatch):
    monkeypatch.setattr(progress, "TICK", 0.01)
    monkeypatch.setattr(compilation, "LONGEST", 0.3)
    said = []
    follower = Compilation(USUAL, lambda *what: said.append(what), True)
    with follower.followed():
        compiled(lanes.run_lanes)
        follower.await_verdict()
    told = [seconds for text, seconds in said if "2 of 2: verdict" in text]
    assert len(told) > 3
    assert told == sorted(told)
    assert said[-1][0] == ""
    assert told[-1] <= said[-1][1]


def test_in_python_it_is_said_too_unless_asked_not_to(monkeypatch, capsys):
    tell = compilation.notice()
    for seconds in (0.0, 1.0, 2.0, 5.5, 6.0):
        tell("compiling", seconds)
    tell("", 7.0)
    assert capsys.readouterr() == ("", "compiling\ncompiling: 6 s\n")
    assert compilation.notice(quiet=True) is None
    with compilation.silent(True), compilation.silent(False):
        assert compilation.notice() is None
    with compilation.silent(False):
        assert compilation.notice() is not None
    monkeypatch.setattr(compilation.multiprocessing, "parent_process", lambda: object())
    assert compilation.notice() is None


# ---- the process itself --------------------------------------------------------------------------


def test_a_process_that_fails_says_why_and_ends():
    process = elsewhere.begin(["orbit"], USUAL._replace(scene="no such kind"), writes=False)
    assert process.stdout.readline() == "orbit failed 'no such kind'\n"
    assert process.wait(20) == 1
    elsewhere.end(process)


def test_where_no_process_can_be_begun_there_is_none(monkeypatch):
    monkeypatch.setattr(sys, "executable", "/no/such/python")
    assert elsewhere.begin(["orbit"], USUAL, writes=False) is None


def test_a_process_ends_with_whoever_began_it(monkeypatch, tmp_path):
    """Its standard input ends when this process does, even by SIGKILL."""
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path))  # empty: it has long to compile
    monkeypatch.setenv("NUMBA_DISABLE_JIT", "0")
    process = elsewhere.begin(["verdict"], USUAL, writes=False)
    with contextlib.suppress(subprocess.TimeoutExpired):
        process.wait(2.0)
    assert process.poll() is None
    assert os.getpgid(process.pid) != os.getpgid(0)  # Ctrl-C in the terminal is not for it
    process.stdin.close()
    assert process.wait(20) == 1
    assert process.stdout.read() == ""
    process.stdout.close()


def test_threads_are_those_of_the_run():
    threads.use_threads(1)
    try:
        assert not elsewhere.may_help()
    finally:
        threads.use_threads(None)
