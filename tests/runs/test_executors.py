"""Lanes handed out to threads: each once, in any order, and all is quiet when the call returns."""

import os
import threading
import time

import numpy as np
import pytest

from nlds_vines.runs import executors
from nlds_vines.runs.executors import in_pieces, most_threads, threads_in_use, use_threads

pytestmark = pytest.mark.filterwarnings("ignore:.*multi-threaded, use of fork:DeprecationWarning")


@pytest.fixture(autouse=True)
def eight(monkeypatch):
    monkeypatch.setenv("NUMBA_NUM_THREADS", "8")
    monkeypatch.setattr(executors, "_used", None)


@pytest.mark.parametrize("lanes", [0, 1, 2, 7, 100, 1001])
@pytest.mark.parametrize("least", [1, 5, 2000])
@pytest.mark.parametrize("used", [1, 2, 8])
def test_every_lane_is_done_once(lanes, least, used):
    use_threads(used)
    done, pieces = np.zeros(lanes, int), []

    def work(begin, end):
        done[begin:end] += 1
        pieces.append(end - begin)

    in_pieces(work, lanes, least)
    assert (done == 1).all()
    small = [size for size in pieces if size < least]
    assert len(small) <= 1  # what is left at the end


def test_pieces_become_smaller_or_are_single_lanes_where_these_differ_most():
    pieces = []
    in_pieces(lambda begin, end: pieces.append((begin, end - begin)), 1000)
    sizes = [size for _, size in sorted(pieces)]
    assert sizes == sorted(sizes, reverse=True)
    assert sizes[0] <= 1000 / 8 / executors.SHARE
    assert sizes[-1] == 1
    sizes = []
    in_pieces(lambda begin, end: sizes.append(end - begin), 1000, 1, 1)
    assert sizes == [1] * 1000
    # few lanes are not worth a thread
    who = set()
    in_pieces(lambda begin, end: who.add(threading.current_thread()), 10, least=6)
    assert who == {threading.current_thread()}


def test_threads_that_are_ready_take_what_others_have_no_time_for():
    """One lane takes as long as forty others: with equal shares, twice as long as here."""
    began = time.perf_counter()
    use_threads(2)
    in_pieces(lambda begin, end: time.sleep(0.2 * (begin == 0) + 0.005 * (end - begin)), 42)
    assert time.perf_counter() - began < 0.3


def test_an_error_stops_the_others_and_nothing_is_at_work_afterwards():
    begun, ended = [], []

    def work(begin, end):
        begun.append(begin)
        if len(begun) == 3:
            raise MemoryError("the third piece")
        time.sleep(0.01)
        ended.append(begin)

    with pytest.raises(MemoryError, match="the third piece"):
        in_pieces(work, 10_000)
    assert len(ended) == len(begun) - 1
    assert len(begun) < 30  # of hundreds
    in_pieces(lambda begin, end: None, 100)  # and the next call is as ever


def test_the_caller_may_be_interrupted_between_two_pieces():
    """As by the second Ctrl-C: what was begun is finished, nothing else is begun."""
    begun, ended = [], []
    caller = threading.current_thread()

    def work(begin, end):
        begun.append(begin)
        if threading.current_thread() is caller and len(begun) > 10:
            raise KeyboardInterrupt
        time.sleep(0.002)
        ended.append(begin)

    with pytest.raises(KeyboardInterrupt):
        in_pieces(work, 10_000)
    count = len(begun)
    assert len(ended) == count - 1
    time.sleep(0.05)
    assert len(begun) == count


def test_two_callers_do_not_disturb_each_other():
    done = np.zeros((4, 500), int)

    def call(row):
        def work(begin, end):
            done[row, begin:end] += 1
            time.sleep(0)

        in_pieces(work, 500)

    callers = [threading.Thread(target=call, args=(row,)) for row in range(4)]
    for caller in callers:
        caller.start()
    for caller in callers:
        caller.join()
    assert (done == 1).all()


@pytest.mark.skipif(not hasattr(os, "fork"), reason="no fork here")
def test_a_fork_has_threads_of_its_own():
    in_pieces(lambda begin, end: time.sleep(0.001), 100)  # the threads of this process are there
    child = os.fork()
    if child == 0:
        done, status = np.zeros(100, int), 1
        try:

            def work(begin, end):
                done[begin:end] += 1
                time.sleep(0.001)

            in_pieces(work, 100)
            status = 0 if (done == 1).all() else 2
        finally:
            os._exit(status)
    for _ in range(500):
        ended, status = os.waitpid(child, os.WNOHANG)
        if ended:
            break
        time.sleep(0.01)
    else:
        os.kill(child, 9)
        os.waitpid(child, 0)
        pytest.fail("the child waits for threads that it does not have")
    assert os.waitstatus_to_exitcode(status) == 0


def test_how_many_threads_there_are_holds_for_all_and_starts_none(monkeypatch):
    before = threading.active_count()
    use_threads(8)
    assert threading.active_count() == before
    in_pieces(lambda begin, end: None, 100)
    assert threading.active_count() == before  # and none is left behind
    assert (most_threads(), threads_in_use()) == (8, 8)
    assert use_threads(3) == threads_in_use() == 3
    assert use_threads(100) == threads_in_use() == 8
    assert use_threads(None) == threads_in_use() == 8
    monkeypatch.delenv("NUMBA_NUM_THREADS")
    assert 1 <= use_threads(None) <= os.cpu_count()
    # what one thread chooses holds for all
    other = threading.Thread(target=use_threads, args=(2,))
    other.start()
    other.join()
    assert threads_in_use() == 2
