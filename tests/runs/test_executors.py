"""Lanes handed out to threads: each once, in any order, and all is quiet when the call returns."""

import multiprocessing
import os
import threading
import time
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

from nlds_vines.runs import executors
from nlds_vines.runs.executors import in_pieces, most_threads, threads_in_use, use_threads

pytestmark = pytest.mark.filterwarnings("ignore:.*multi-threaded, use of fork:DeprecationWarning")

LONGEST = 60.0
"""Seconds after which something that should happen is taken for something that does not."""


@pytest.fixture(autouse=True)
def eight(monkeypatch):
    monkeypatch.setenv("NUMBA_NUM_THREADS", "8")
    monkeypatch.setattr(executors, "_used", None)


def every_lane_is_done_once(lanes, least=1):
    done, pieces = np.zeros(lanes, int), []

    def work(begin, end):
        done[begin:end] += 1
        pieces.append(end - begin)
        time.sleep(0)

    in_pieces(work, lanes, least)
    assert (done == 1).all()
    small = [size for size in pieces if size < least]
    assert len(small) <= 1  # what is left at the end


@pytest.mark.parametrize("lanes", [0, 1, 2, 7, 100, 1001])
@pytest.mark.parametrize("least", [1, 5, 2000])
@pytest.mark.parametrize("used", [1, 2, 8])
def test_every_lane_is_done_once(lanes, least, used):
    use_threads(used)
    every_lane_is_done_once(lanes, least)


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
    """The first piece lasts until the other thread has done all the rest, not its share alone."""
    use_threads(2)
    lanes, done, rest = 42, [], threading.Event()
    first = lanes // (2 * executors.SHARE)

    def work(begin, end):
        if begin == 0:
            assert end == first
            assert rest.wait(LONGEST)
            return
        done.extend(range(begin, end))
        if len(done) == lanes - first:
            rest.set()

    in_pieces(work, lanes)
    assert done == [*range(first, lanes)]


@pytest.mark.parametrize(
    ("error", "fails"),
    [
        (MemoryError, lambda count, is_caller: count == 3),
        (KeyboardInterrupt, lambda count, is_caller: is_caller and count > 10),
    ],
)
def test_an_error_or_ctrl_c_stops_all_and_nothing_is_at_work_afterwards(error, fails):
    """The second Ctrl-C reaches the caller, between two pieces: what was begun is finished."""
    begun, ended, failed = [], [], threading.Event()
    caller = threading.current_thread()

    def work(begin, end):
        begun.append(begin)
        count = len(begun)
        if fails(count, threading.current_thread() is caller):
            failed.set()
            raise error("a piece")
        if count > 10:  # however late the thread that fails
            assert failed.wait(LONGEST)
        time.sleep(0.01)
        ended.append(begin)

    with pytest.raises(error, match="a piece"):
        in_pieces(work, 10_000)
    count = len(begun)
    assert len(ended) == count - 1
    assert count < 150  # of more than 200
    time.sleep(0.05)
    assert len(begun) == count
    every_lane_is_done_once(100)  # and the next call is as ever


def test_two_callers_do_not_disturb_each_other():
    with ThreadPoolExecutor() as callers:
        for call in [callers.submit(every_lane_is_done_once, 500) for _ in range(4)]:
            call.result()


@pytest.mark.skipif(not hasattr(os, "fork"), reason="no fork here")
def test_a_fork_has_threads_of_its_own():
    in_pieces(lambda begin, end: time.sleep(0.001), 100)  # the threads of this process are there
    child = multiprocessing.get_context("fork").Process(target=every_lane_is_done_once, args=(100,))
    child.start()
    child.join(LONGEST)
    child.kill()  # if it waits for threads that it does not have
    child.join()
    assert child.exitcode == 0


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
