"""How kernels are compiled: for whom, how often, and what rests meanwhile."""

import gc
import os
import subprocess
import sys
from pathlib import Path

import numba
import pytest

import nlds_vines
from nlds_vines.kernels import compiling, elementary, lanes
from nlds_vines.kernels.compiling import Inner, jit, told_of_compilations

pytestmark = pytest.mark.skipif(numba.config.DISABLE_JIT, reason="nothing is compiled")


@jit
def doubled(x):
    return x + x


def kernel(text, name="f", **options):
    """Return a kernel that is compiled now: no cache on the disk knows it."""
    space = {"gc": gc, "jit": jit}
    exec(text, space)
    function = space[name]
    function.__module__ = "nlds_vines.kernels.made_up"
    made = numba.njit(error_model="numpy", nogil=True, **options)(function)
    return made


def test_kernels_that_kernels_call_have_no_wrapper_and_python_calls_them_all_the_same():
    inner = doubled
    assert isinstance(inner, Inner)
    assert inner(16.0) == 32.0
    assert all(overload.entry_point is None for overload in inner.overloads.values())
    assert inner.entry is inner.entry
    assert not isinstance(inner.entry, Inner)
    assert all(overload.entry_point for overload in inner.entry.overloads.values())
    for entry in (lanes.run_lanes, lanes.judge_lanes):
        assert not isinstance(entry, Inner)


def test_an_inner_kernel_is_compiled_once_for_kernels_and_for_python():
    """Python's way to it has files of its own in the cache, which hold a wrapper."""
    names = {elementary.exp._cache._cache_file._index_name for _ in range(2)}
    names.add(elementary.exp.entry._cache._cache_file._index_name)
    assert len(names) == 2


def test_the_collector_rests_while_something_is_compiled_and_works_afterwards():
    seen = []
    made = kernel("def f(x):\n    return x + 1")
    with told_of_compilations(lambda kernel: seen.append((kernel, gc.isenabled()))):
        assert made(1) == 2
        assert gc.isenabled()
        assert made(2) == 3
    assert [one for one, _ in seen] == [made]


def rests(monkeypatch, text, **how):
    """Return whether the collector was at work at each compilation within one of `text`."""
    found = []
    made = kernel(text, **how)
    with told_of_compilations(lambda _: found.append(gc.isenabled())):
        made(1)
    return found


def test_nested_compilations_are_one_pause(monkeypatch):
    found = rests(monkeypatch, "def f(x):\n    return max(abs(x), round(2.5))")
    assert len(found) > 1
    assert found[0]  # it is told of before
    assert not any(found[1:])
    assert gc.isenabled()


def test_functions_of_others_are_compiled_as_ever():
    """Also those that are made at run time and belong to no module, as some solvers have them."""
    made = kernel("def f(x):\n    return x + 1")
    made.py_func.__module__ = None
    seen = []
    with told_of_compilations(lambda _: seen.append(gc.isenabled())):
        assert made(1) == 2
    assert seen == [True]
    assert gc.isenabled()


def test_frames_have_room_while_something_is_compiled():
    """Notices: a frame as small as any other, at whose end memory is mapped and unmapped."""
    room = compiling._with_room.__code__.co_stacksize * 8
    assert room > 2**20  # bytes: its chunk is of 2 MB, of which the rest is left
    assert 2**21 - room > 2**19
    assert compiling._with_room(lambda x: x + 1, 1) == 2


def test_an_error_of_the_compiler_lets_the_collector_work_again():
    with pytest.raises(numba.TypingError):
        kernel("def f(x):\n    return x + 'a'")(1)
    assert gc.isenabled()


def test_whoever_ends_a_compilation_before_it_begins_stops_nothing_else():
    made = kernel("def f(x):\n    return x + 1")

    def refuse(kernel):
        raise RuntimeError("no memory")

    with told_of_compilations(refuse), pytest.raises(RuntimeError, match="no memory"):
        made(1)
    assert gc.isenabled()
    assert made(1) == 2


def test_a_collector_that_is_off_stays_off():
    gc.disable()
    try:
        assert kernel("def f(x):\n    return x + 1")(1) == 2
        assert not gc.isenabled()
    finally:
        gc.enable()


def test_what_others_compile_is_their_business():
    found = []

    def watch(kernel):
        found.append(gc.isenabled())

    theirs = numba.njit(lambda x: max(abs(x), round(2.5)))
    with told_of_compilations(watch):
        theirs(1)
    assert len(found) > 1
    assert all(found)


def test_what_other_sources_left_in_the_cache_is_removed_once(tmp_path):
    folder = tmp_path / "cache"
    compiling._remove_stale_files(folder)  # makes it
    (folder / "orbit.orbit-1.py311.nbi").touch()
    compiling._remove_stale_files(folder)
    assert (folder / "orbit.orbit-1.py311.nbi").exists()  # of these sources
    (folder / "nlds_vines.stamp").write_text("of others")
    (folder / "a note").touch()
    compiling._remove_stale_files(folder)
    assert sorted(path.name for path in folder.iterdir()) == ["a note", "nlds_vines.stamp"]


@pytest.mark.parametrize("level", ["3", "1"])
def test_the_stamp_knows_how_much_is_optimised(level):
    """Numba's key of a compiled function does not."""
    program = "from nlds_vines.kernels.compiling import source_stamp; print(source_stamp())"
    done = subprocess.run(
        [sys.executable, "-c", program],
        capture_output=True,
        text=True,
        check=True,
        env={
            **os.environ,
            "PYTHONPATH": str(Path(nlds_vines.__path__[0]).parent),
            "NUMBA_OPT": level,
        },
    )
    assert (done.stdout.strip() == compiling.source_stamp()) == (int(level) == numba.config.OPT)
