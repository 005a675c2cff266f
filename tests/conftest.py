"""The tiers of tests: what a change needs, what kernels need, what takes long.

A test of the default tier compiles nothing but the configurations of `configurations.py`, which
many tests share, and takes less than three seconds of the processor unless it is marked
`slow("why")`.  One that breaks this fails, and is told which mark it wants.
"""

import json
import os
import signal
import subprocess
import sys
import time
from collections import Counter
from functools import cache
from pathlib import Path

import pytest

try:
    import fcntl
    import resource
except ImportError:  # not on Windows
    fcntl = resource = None

if signal.getsignal(signal.SIGINT) == signal.SIG_IGN:  # a shell begins `pytest &` like this
    signal.signal(signal.SIGINT, signal.default_int_handler)  # or no program could be interrupted

TESTS = Path(__file__).parent

FIRST = (
    "contract/test_plain.py",
    "contract/test_specialization.py",
    "property/test_no_missed_impact.py",
    "continuation/test_branches.py",
    "contract/test_resumed_after_kill.py",
    "contract/test_same_bits.py",
    "property/test_limit.py",
    "portrait/test_portrait.py",
    "continuation/test_closed_forms.py",
    "contract/test_response_history.py",
    "kernels/test_variations.py",
    "contract/test_cache.py",
    "engine/test_classification.py",
    "contract/test_determinism.py",
    "contract/test_readme.py",  # when the kernels of hosts are compiled, which its pages need
)
"""Files below `tests` that take longest, in whatever tier: they run first."""

APART = ("contract/test_plain.py", "contract/test_resumed_after_kill.py")
"""Files whose tests share no costly fixture: several workers may run them."""

OF_HOSTS = (
    "kernels/test_host_verdict.py",
    "kernels/test_host_variations.py",
    "kernels/test_host_impact.py",
    "kernels/test_hosts.py",
    "kernels/test_cyclic_chain.py",
    "kernels/test_host_watch.py",
    "kernels/test_host_loads.py",
    "contract/test_host_histories.py",
    "tuning/test_tuning_of_hosts.py",
    "bifurcation/test_scans_of_hosts.py",
    "explore/test_pages_of_hosts.py",
    "continuation/test_branches_of_hosts.py",
    "portrait/test_portraits_of_hosts.py",
)
"""Files that need the kernels of hosts: one worker runs them, and compiles these kernels once."""

SECONDS = 3.0
"""CPU time of a test without a mark."""

BUSY = 3.0
"""How many times as long a test may take where the processor is shared."""

REPEATED = "TEST_REPEATED"
"""The variable of the environment that says that a test is measured for the second time."""

COSTS = os.environ.get("TEST_COSTS")
"""A file to which each test appends its costs: CPU times [s], of processes that have ended and of
compiling, too. Of the files that `test_plain.py` runs, those are part of its own."""

MANY = 300
"""Tests of a run for which the configurations are compiled beforehand, on all processors."""


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_make_scheduler(config, log):
    """Hand out whole files, but the tests of `APART` one by one, and those of hosts together."""
    from xdist.scheduler import LoadScopeScheduling

    class FilesAndTests(LoadScopeScheduling):
        def _split_scope(self, nodeid):
            file = nodeid.split("::")[0]
            if file.endswith(OF_HOSTS):
                return "hosts"
            return nodeid if file.endswith(APART) else file

    return FilesAndTests(config, log)


def pytest_collection_modifyitems(config, items):
    """Leave tests marked `plain` to a process without the compiler, and order the others.

    The files of `OF_HOSTS` and `FIRST` come first, then those of many tests.
    """
    if os.environ.get("NUMBA_DISABLE_JIT") != "1":
        plain = {item for item in items if item.get_closest_marker("plain")}
        config.hook.pytest_deselected(items=[*plain])
        items[:] = [item for item in items if item not in plain]
    first = (*OF_HOSTS, *FIRST)
    if missing := [name for name in first if not (TESTS / name).exists()]:
        raise pytest.UsageError(f"{__file__} names files that are not there: {missing}")
    rank = {TESTS / name: place for place, name in enumerate(first)}
    count = Counter(item.path for item in items)
    items.sort(key=lambda item: (rank.get(item.path, len(first)), -count[item.path], item.path))


def pytest_collection_finish(session):
    if sum(not in_a_tier(item) for item in session.items) > MANY:
        shared_files()


def in_a_tier(item):
    """Return True if a test is not of the default tier; files of plain Python are not, either."""
    named = any(item.get_closest_marker(name) for name in ("kernels", "long"))
    return named or item.path.name.startswith("plain_")


@cache
def shared_files():
    """Return the files of what the configurations compile, which are compiled by then."""
    from nlds_vines.kernels.numerics import stored_code

    place = stored_code.folder() or TESTS
    with (place / "configurations.lock").open("a") as lock:
        if fcntl is not None:
            fcntl.flock(lock, fcntl.LOCK_EX)  # one process at a time
        done = subprocess.run(
            [sys.executable, str(TESTS / "configurations.py")],
            env={**os.environ, "PYTHONPATH": os.pathsep.join([str(TESTS.parent), str(TESTS)])},
            capture_output=True, text=True, check=False,
        )  # fmt: skip
    assert done.returncode == 0, done.stderr
    return frozenset(json.loads(done.stdout))


compiled = {}
"""Kernels that were compiled since the test before, with what they were compiled for before."""

compiling = {}
"""The kernels that Python calls and this test has compiled, by their names, with CPU times [s]."""


@pytest.fixture(scope="session", autouse=True)
def followed():
    """Note which of the program's kernels that Python calls are compiled, and how long."""
    from nlds_vines.kernels.numerics.compiling import Inner, told_of_compilations

    began = {}

    def note(kernel):
        ours = str(kernel.place[0]).startswith("nlds_vines.")
        if ours and not isinstance(kernel, Inner):
            compiled.setdefault(kernel, set(kernel.overloads))
            began[kernel] = time.process_time()

    def note_end(kernel):
        if kernel in began:
            name = kernel.place[1].removesuffix("_from_python")
            seconds = time.process_time() - began.pop(kernel)
            compiling[name] = round(compiling.get(name, 0.0) + seconds, 2)

    with told_of_compilations(note, note_end):
        yield


@pytest.fixture(scope="session", autouse=True)
def parsed_once():
    """Let all renderers of pixels share the formulas that Matplotlib has parsed.

    Each keeps its own, and a page has several: a fifth of the time of the tests that draw.
    """
    if "matplotlib" not in sys.modules:
        yield
        return
    from matplotlib.mathtext import MathTextParser

    usual, shared = MathTextParser._parse_cached, MathTextParser("agg")

    @cache
    def parsed(*key):
        return usual(shared, *key)

    def parse_cached(parser, *key):
        is_of_pixels = parser._output_type == shared._output_type
        return parsed(*key) if is_of_pixels else usual(parser, *key)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(MathTextParser, "_parse_cached", parse_cached)
        yield


@pytest.hookimpl(hookwrapper=True)
def pytest_runtest_protocol(item):
    """Note what a test costs, with the fixtures that it is the first to need."""
    began = spent()
    compiling.clear()
    yield
    if COSTS is not None and os.environ.get("NUMBA_DISABLE_JIT") != "1":
        costs = {"test": item.nodeid, "seconds": round(spent() - began, 2), "compiling": compiling}
        with open(COSTS, "a", encoding="utf-8") as file:  # a line is written at once
            file.write(json.dumps(costs) + "\n")


def spent():
    """Return the CPU time [s] of this process and of those that have ended in it."""
    if resource is None:
        return time.process_time()
    used = [resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)]
    return sum(one.ru_utime + one.ru_stime for one in used)


def is_in_time_alone(test):
    """Measure a test once more, in a process of its own; return True if it keeps to its limit.

    Other programs only ever add to the time of a test, so that the smaller of two times counts.
    """
    done = subprocess.run(
        [sys.executable, "-m", "pytest", "-n", "0", "-p", "no:cacheprovider", test],
        env={**os.environ, REPEATED: "1"}, cwd=TESTS.parent, capture_output=True, check=False,
    )  # fmt: skip
    return done.returncode == 0


@pytest.fixture(autouse=True)
def within_its_tier(request):
    """Fail a test of the default tier that compiles what no other needs, or takes long."""
    began = spent()
    yield
    seconds, fresh = spent() - began, dict(compiled)
    compiled.clear()
    if in_a_tier(request.node):
        return
    for kernel, before in fresh.items():
        files = {kernel.file(kinds) for kinds in set(kernel.overloads) - before} - {None}
        if not files <= shared_files():
            pytest.fail(f"it compiles {'.'.join(kernel.place)} for other arguments: mark `kernels`")
    if fresh or request.node.get_closest_marker("slow") or seconds <= BUSY * SECONDS:
        return
    if REPEATED in os.environ or not is_in_time_alone(request.node.nodeid):
        pytest.fail(f"it took {seconds:.1f} s of the processor: mark `slow`, or `kernels`")


@pytest.fixture
def error_of():
    """Return a function that calls another, which refuses in one line, and returns that line."""

    def line(call, *arguments, **keywords):
        from nlds_vines.errors import RequestError

        with pytest.raises(RequestError) as refused:
            call(*arguments, **keywords)
        assert "\n" not in str(refused.value)
        return str(refused.value)

    return line


@pytest.fixture
def here(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.fixture
def ask(capsys):
    """Return a function that gives `nlds-vines` its words, and returns what is said (out, err)."""

    def printed(*words, status=0):
        from nlds_vines.__main__ import main

        assert main([str(word) for word in words]) == status
        return capsys.readouterr()

    return printed


@pytest.fixture
def answer(ask):
    """Return a function that gives `nlds-vines` its words and returns what it prints."""
    return lambda *words, status=0: ask(*words, status=status).out


@pytest.fixture
def refusal(ask):
    """Return a function that gives `nlds-vines` words that it refuses, and returns its line."""

    def line(*words):
        out, err = ask(*words, status=2)
        assert (out, err.count("\n")) == ("", 1)
        return err

    return line
