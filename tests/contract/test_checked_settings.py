"""Every setting of every request is checked, in a file and by its option.

What is tried follows from how a setting is described (`model/setting.py`), what must be said from
the tables below.  A setting that is neither is noticed.
"""

from importlib import import_module
from typing import NamedTuple

import numpy as np
import pytest

from nlds_vines.bifurcation.request import Scan
from nlds_vines.bifurcation.response_curves.request import CurveRequest
from nlds_vines.continuation.request import Begin, Continuation
from nlds_vines.errors import RequestError
from nlds_vines.loads.request import HistoryRequest, load_response_history
from nlds_vines.model.loads.loading import ALL, Loading
from nlds_vines.model.setting import Checked, OneOf, Real, Text, Truth, Whole, settings_of
from nlds_vines.orbits.starts import Start
from nlds_vines.portrait.request import PortraitRequest, Times
from nlds_vines.tuning.request import Search, Surface, Tuning, load_tuning

NAN = float("nan")


class Task(NamedTuple):
    """A kind of request: the function that reads its files, and the owners of its settings."""

    module: str
    load: str
    owners: tuple
    least: dict  # a file of this kind that is complete
    command: str

    @property
    def settings(self):
        return [said for owner in self.owners for said in settings_of(owner).values()]

    def read(self, *given):
        return getattr(self.form_module, self.load)(*given)

    @property
    def form_module(self):
        return import_module(f"nlds_vines.{self.module}.request")


SET6 = {"system": "ssul-set6"}
SCAN = {**SET6, "vary": {"omega": {"values": [6.0, 6.5]}}}
TUNING = {**SET6, "surface": {"parameters": ["k2", "c2"]}}
BLOW = {**SET6, "load": {"impulse": 1.0}}
TASKS = {
    "scan": Task("bifurcation", "load_scan", (Start, Scan), SCAN, "bifurcation"),
    "page of curves": Task(
        "bifurcation.response_curves",
        "load_curves",
        (Start, Scan, CurveRequest),
        {**SCAN, "curves": [{}]},
        "response-curves",
    ),
    "portrait": Task("portrait", "load_portrait", (Times, PortraitRequest), SET6, "portrait"),
    "tuning": Task(
        "tuning", "load_tuning", (Tuning, Search, Surface), TUNING, "tuning --surface=k2,c2"
    ),
    "tuning under a load": Task(
        "tuning",
        "load_tuning",
        (Search, Surface, HistoryRequest, Loading),
        {**TUNING, "load": {"impulse": 1.0}},
        "tuning --surface=k2,c2 --impulse=1",
    ),
    "continuation": Task(
        "continuation", "load_continuation", (Begin, Continuation), SET6, "continuation"
    ),
    "response history": Task(
        "loads",
        "load_response_history",
        (HistoryRequest, Loading),
        BLOW,
        "response-history --impulse=1",
    ),
}
"""All kinds of requests whose files have tables of settings, by the word for them."""


def word_of(kind):
    return kind.removesuffix(" under a load")


every_task = pytest.mark.parametrize("kind", TASKS)
no_list = [(3, "= 3 must be a list"), ("a", "= 'a' must be a list")]
steps = [
    (3, "= 3; allowed: 4 to 1e6"),
    (1e7, "allowed: 4 to 1e6"),
    (NAN, "= nan"),
    ("28", "= '28'"),
]
CHECKED = {
    "tolerance": [
        *(
            (value, f"tolerance = {value!r}; allowed: 1e-13 to 0.001, or draft, standard, fine")
            for value in (0.0, 1e-14, -1e-9, 1e-2, "1e-9", "drft", "standard ")
        ),
        (NAN, "tolerance = nan must be a finite number"),
        *((value, "must be a number") for value in (True, [1e-9], 1j)),
    ],
    "nodes": [
        (value, f"nodes = {value!r} must be a whole number from 2 to 60")
        for value in (1, 61, 8.0, "many", True)
    ],
    "contact_steps": steps,
    "period_steps": steps,
    "state": [
        ("rest", "state = 'rest' must be a list of"),
        ([1, 2, NAN, 4], "nan"),
        ([1, "a", 0, 0], "state = 'a' must be a number"),
        ([1, [2], 0, 0], "state = [2] must be a number"),
    ],
    "phase": [("a", "phase = 'a' must be a number"), (NAN, "phase = nan"), (7.0, "phase = 7.0")],
    "want": [
        ("section", "want = 'section' must be a list"),
        ([], "empty request; allowed: section"),
        (["enrgy"], "unknown want 'enrgy'; did you mean 'energy'"),
        ([3], "unknown want 3"),
        (["energy", "energy"], "names something twice"),
    ],
    "signals": [
        *no_list,
        (np.array(["x1", "x2"]), "must be a list of words"),
        ([1], "unknown signal 1; did you mean 'x1'"),
    ],
    "windows": [
        (3, "windows = 3 must be a list of pairs [begin, end]"),
        (["a:b"], "windows = 'a:b' must be BEGIN:END, two numbers of forcing periods"),
        ([100], "windows = 100 must be BEGIN:END"),
        ([[9, 5]], "end of windows = 5"),
    ],
    "panels": [
        (["forces"], "unknown panels 'forces'; did you mean 'force'"),
        (["force", "force"], "names something twice"),
        (np.array(["force"]), "must be a list of words"),
        ([], "empty"),
    ],
    "show": [
        (3, "show = 3 must be a list of words"),
        ([], "empty request; allowed: E1max"),
        (["x1max"], "unknown show 'x1max'; did you mean 'x1_max'"),
        (["E1max", "E1max"], "names something twice"),
    ],
    "parameters": [("k2", "must be two names"), (["k2"], "must be two names")],
    "states": [*no_list, ([1], "state = 1 must be a list of numbers")],
    "values": [*no_list, (["x"], "value = 'x' must be a number"), ([NAN], "value = nan")],
    "periods": [*no_list, ([0.5], "period = 0.5 must be a whole number from 1 to 1000000")],
    "impulse": [(1e16, "impulse = 1e+16; allowed"), (NAN, "impulse = nan must be a finite number")],
    **{kind: [(3, f"{kind} = 3 must be a table"), ({}, "is missing")] for kind in ALL},
}
"""What is tried of settings that functions check, by key, with what must be said of it."""


def tried(said):
    """Return wrong values of a setting, each with what must be said of it."""
    key, check = said.key, said.check
    match check:
        case Whole(low, high):
            words = f"must be a whole number from {low} to {high}"
            wrong = (low - 1, high + 1, low + 0.5, float(low), True, "1", NAN)
            return [(value, f"{key} = {value!r} {words}") for value in wrong]
        case Real(low, high, inside):
            words = f" must be between {low:g} and {high:g}" if inside else f"; allowed: {low:g} to"
            outside = (low, high) if inside else (low - 1.0, high + 1.0)
            return [
                *((value, f"{key} = {value!r}{words}") for value in outside),
                (NAN, f"{key} = nan must be a finite number"),
                ("a", f"{key} = 'a' must be a number"),
                (True, f"{key} = True must be a number"),
            ]
        case OneOf(words, what):
            longest, allowed = max(words, key=len), f"allowed: {', '.join(words)}"
            return [
                ("?", f"unknown {what or key} '?'; {allowed}"),
                (f"{longest}x", f"did you mean {longest!r}? {allowed}"),
                (3, f"unknown {what or key} 3; {allowed}"),
            ]
        case Text():
            return [
                (3, f"{key} = 3 must be a string"),
                ("a\0b", f"{key} 'a\\x00b' holds a null character"),
                ("a\nb", r"holds '\n': control characters and line ends are not allowed"),
                ("a\x1b[31m", r"holds '\x1b'"),
                ("x" * 1001, "has 1001 characters; allowed: up to 1000"),
            ]
        case Truth():
            return [(value, f"{key} = {value!r} must be true or false") for value in (1, "yes")]
    return CHECKED[key]


@every_task
def test_all_settings_are_known_here(kind):
    form = TASKS[kind].form_module.FORM
    alike = [task for task in TASKS.values() if task.load == TASKS[kind].load]
    known = {(said.table, said.key) for task in alike for said in task.settings}
    assert form.kind == word_of(kind)
    assert known == {(table, key) for table, keys in form.tables.items() for key in keys or ()}
    TASKS[kind].read(TASKS[kind].least)  # or else all could be refused for a reason that is none


@every_task
def test_a_wrong_value_is_refused_with_its_place_and_what_is_allowed(kind, error_of):
    task = TASKS[kind]
    for said in task.settings:
        table = task.least.get(said.table, {})
        for value, words in tried(said):
            wrong = {**task.least, said.table: {**table, said.key: value}}
            line = error_of(task.read, wrong)
            assert line.startswith(f"{word_of(kind)}: ")
            assert f"[{said.table}]: " in line
            assert words in line
        line = error_of(task.read, {**task.least, said.table: {f"{said.key}x": 1}})
        assert f"[{said.table}]: unknown key '{said.key}x'; did you mean '{said.key}'" in line


NUMBERS = {
    "1_0": "in the digits 0 to 9, without _", "٣": "in the digits 0 to 9", "0x10": "'0x10'",
    "ten": "'ten'", "": "''", "1" * 5000: "must be a",
}  # fmt: skip
"""What is no number, and what must be said of it."""


def texts(said):
    """Return wrong texts of an option, each with what must be said of it."""
    match said.check:
        case Whole(low, high):
            outside = [
                (str(n), f"{said.key} = {n} must be a whole number") for n in (low - 1, high + 1)
            ]
            return [*outside, ("2.5", "must be a whole number"), *NUMBERS.items()]
        case Real():
            return [("nan", f"{said.key} = nan"), ("1e10", f"{said.key} = 1"), *NUMBERS.items()]
        case Truth() | Text():
            return []
        case Checked(listed=True):
            lists = [(value, words) for value, words in tried(said) if isinstance(value, list)]
            return [
                (",".join(v), words) for v, words in lists if all(isinstance(w, str) for w in v)
            ]
    return [(v, words) for v, words in tried(said) if isinstance(v, str) and not v[0].isdigit()]


@every_task
def test_an_option_is_refused_in_its_own_words(kind, here, answer, refusal):
    command, *usual = TASKS[kind].command.split()
    told = answer(command, "--help-all" if "--help-all" in answer(command, "--help") else "--help")
    for said in TASKS[kind].settings:
        for text, words in texts(said) if said.has_option and said.flag in told else ():
            err = refusal(command, *usual, f"{said.flag}={text}")
            assert words in err
            assert said.flag in err or ("command line: " in err and f"[{said.table}]: " in err)
    assert list(here.iterdir()) == []


# ---- what may vary -------------------------------------------------------------------------------

LOADS = {
    "blow": {"impulse": 1.0, "repeat": 2, "every": 1.0},
    "record": {"values": [0.0, 1.0, 0.0], "dt": 0.01},
    "tone": {"amplitude": 1.0, "omega": 3.0},
    "sweep": {"amplitude": 1.0, "first": 3.0, "last": 5.0, "length": 9.0},
    "noise": {"rms": 1.0, "high": 20.0},
    **{
        kind: {"peak": 1.0, "length": 0.1, "repeat": 2, "every": 1.0}
        for kind in ("half_sine", "triangular", "rectangular", "friedlander")
    },
}
NUMBERS_OF_LOADS = [
    *(("impulse", "scale")),
    *(f"{kind}.{said.key}" for kind in ALL for said in settings_of(ALL[kind]).values()),
]
RANGES = ([-1.0, 0.0, 1.0], [1.0, 1.5, 2.0], [2.0, 3.0, 4.0], [0.0, 0.5, 1.0], [19.0, 20.0, 21.0])
"""Axes whose ends many settings allow, and not each value between them."""


@pytest.mark.parametrize("name", NUMBERS_OF_LOADS)
def test_every_value_of_an_axis_is_checked_before_anything_is_computed(name):
    kind = name.partition(".")[0]
    acts = {"load": {kind: LOADS[kind]} if kind in LOADS else {"impulse": 1.0}}
    for values in RANGES:
        try:
            request = load_response_history("tmd", {**acts, "vary": {name: {"values": values}}})
        except RequestError:
            continue
        for number in range(request.cases):
            request.case(number)  # as a run makes them


@pytest.mark.parametrize(
    ("name", "values", "words"),
    [
        ("friedlander.peak", np.linspace(-1000, 1000, 1001).tolist(), "friedlander.peak = 0.0"),
        ("noise.seed", [1.0, 1.5, 2.0], "noise.seed = 1.5 must be a whole number"),
        ("blow.repeat", [1.5, 2.0], "blow.repeat = 1.5 must be a whole number"),
        ("friedlander.unit", [1.0, 2.0], "unknown unit 1.0"),
        ("tone.omega", [1.0, 1e8], "cells of time; allowed: 1000000"),
    ],
)
@pytest.mark.parametrize("command", ["response-history --vary", "tuning --over"])
def test_a_value_within_an_axis_of_a_load_is_refused(command, name, values, words, error_of):
    kind = name.partition(".")[0]
    load, key = {"load": {kind: LOADS[kind]}}, command.split("--")[1]
    reads = {"vary": load_response_history, "over": load_tuning}
    line = error_of(reads[key], "tmd", {**load, key: {name: {"values": values}}})
    assert words in line


def test_a_whole_number_is_not_uncertain(error_of):
    tables = {"load": {"blow": LOADS["blow"]}, "uncertain": {"blow.repeat": 1.0}}
    assert "blow.repeat is a whole number" in error_of(load_tuning, "tmd", tables)
    tables = {
        "load": {"friedlander": LOADS["friedlander"]},
        "uncertain": {"friedlander.unit": "5%"},
    }
    assert "friedlander.unit = 'N' must be a number" in error_of(load_tuning, "tmd", tables)


def test_a_text_that_is_no_number_is_refused_in_one_line(here, refusal):
    assert "'a' must be a number" in refusal("response-history", "--impulse=1", "--start=1,a,0,0")
    assert "'a' must be a number" in refusal("tuning", "--impulse=1", "--start=1,a,0,0")
    assert "'²'" in refusal("response-history", "--load=blow:impulse=²")
    assert "must be a" in refusal("response-history", f"--load=blow:impulse={'1' * 5000}")
