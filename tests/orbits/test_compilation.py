"""What is compiled elsewhere meanwhile, what is said of it, and that nothing is left of it."""

import contextlib
import os
import subprocess
import sys
import time

import pytest

from nlds_vines.errors import RequestError
from nlds_vines.kernels import elementary, lanes
from nlds_vines.orbits import compilation, elsewhere
from nlds_vines.orbits.compilation import Compilation
from nlds_vines.orbits.elsewhere import Needed, kernels_of
from nlds_vines.runs import threads

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
    follower = Compilation(needed, said.append, helped)
    with follower.followed():
        for kernel in kernels:
            follower._begins(kernel)
    return said


def test_the_verdict_is_compiled_elsewhere_and_all_is_said_once(begun):
    said = follow(lanes.run_lanes, elementary.exp, lanes.judge_lanes, lanes.run_lanes)
    assert said == ["compiling the kernels of ssul: orbit, verdict (once; about 18 s)"]
    ((kernels, needed, _),) = begun
    assert kernels == ("verdict",)
    assert needed == USUAL


def test_what_is_compiled_here_is_said_too(begun):
    (said,) = follow(lanes.run_lanes, lanes.judge_lanes, helped=False)
    assert said == "compiling the kernels of ssul: orbit, verdict (once; about 30 s)"
    (said,) = follow(lanes.judge_lanes)
    assert said == "compiling the kernels of ssul: verdict (once; about 18 s)"
    (said,) = follow(lanes.run_lanes, needed=USUAL._replace(want=("energy",)))
    assert said == "compiling the kernels of ssul: orbit (once; about 12 s)"
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
    assert len(follow(lanes.run_lanes)) == 1
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
    assert len(follow(lanes.run_lanes)) == 1


@pytest.mark.parametrize("error", [KeyboardInterrupt, MemoryError])
def test_no_process_outlives_what_it_was_begun_for(begun, error):
    def struck():
        follower = Compilation(USUAL, None, True)
        with follower.followed():
            follower._begins(lanes.run_lanes)
            assert begun[0][2].poll() is None
            raise error

    with pytest.raises(error):
        struck()


def test_the_verdict_is_awaited_but_not_for_ever(begun, monkeypatch):
    monkeypatch.setattr(compilation, "LONGEST", 0.1)
    follower = Compilation(USUAL, None, True)
    follower.await_verdict()  # nothing was begun
    with follower.followed():
        follower._begins(lanes.run_lanes)
        began = time.perf_counter()
        follower.await_verdict()
        assert time.perf_counter() - began < 5.0
        assert begun[0][2].poll() is not None
        follower.await_verdict()


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
