"""Requests: every setting is validated, however it is given; what means the same has one hash.

The wrong values follow from the setting's check (`model/setting.py`) or from the tables below, with
the message expected.  A setting with neither fails.
"""

import warnings
from collections.abc import Callable
from contextlib import suppress
from importlib import import_module
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest

import nlds_vines as nv
from nlds_vines.__main__ import main
from nlds_vines.archives.files import toml_text
from nlds_vines.bifurcation.response_curves import load_curves
from nlds_vines.errors import LeftAside, RequestError
from nlds_vines.loads.request import load_response_history
from nlds_vines.model import catalog
from nlds_vines.model import setting as settings
from nlds_vines.model.loads.loading import ALL
from nlds_vines.model.setting import Checked, OneOf, Real, Text, Truth, Whole, settings_of
from nlds_vines.portrait.request import load_portrait
from nlds_vines.tuning.request import load_tuning

NAN = float("nan")
SCANS = Path(__file__).parents[2] / "scans"


class Kind(NamedTuple):
    """A kind of request: how it is read, its smallest complete document, and its command."""

    read: Callable
    least: dict
    command: str

    @property
    def form(self):
        return import_module(self.read.__module__).FORM

    @property
    def settings(self):
        return [entry for table in self.form.tables.values() for entry in table.values()]


SET6 = {"system": "ssul-set6"}
SCAN = {**SET6, "vary": {"omega": {"values": [6.0, 6.5]}}}
TUNING = {**SET6, "surface": {"parameters": ["k2", "c2"]}}
BLOW = {**SET6, "load": {"impulse": 1.0}}
KINDS = {
    "scan": Kind(nv.load_scan, SCAN, "bifurcation"),
    "response curves": Kind(load_curves, {**SCAN, "curves": [{}]}, "response-curves"),
    "portrait": Kind(load_portrait, SET6, "portrait"),
    "tuning": Kind(load_tuning, TUNING, "tuning --surface=k2,c2"),
    "continuation": Kind(nv.load_continuation, SET6, "continuation"),
    "response history": Kind(load_response_history, BLOW, "response-history --impulse=1"),
}
"""All kinds of requests, by the word for them."""

every_kind = pytest.mark.parametrize("kind", KINDS)
no_list = [(3, "= 3 must be a list"), ("a", "= 'a' must be a list")]
steps = [
    (3, "= 3; allowed: 4 to 1e6"), (1e7, "allowed: 4 to 1e6"), (NAN, "= nan"), ("28", "= '28'"),
]  # fmt: skip
CHECKED = {
    "tolerance": [
        *((value, f"tolerance = {value!r}; allowed: 1e-13 to 0.001, or draft, standard, fine")
          for value in (0.0, 1e-14, -1e-9, 1e-2, "1e-9", "drft", "standard ")),
        *((value, "must be a number") for value in (True, [1e-9], 1j)),
        (NAN, "tolerance = nan must be a finite number"),
    ],
    "nodes": [(value, f"nodes = {value!r} must be a whole number from 2 to 60")
              for value in (1, 61, 8.0, "many", True)],
    "contact_steps": steps,
    "period_steps": steps,
    "state": [
        ("rest", "state = 'rest' must be a list of"), ([1, 2, NAN, 4], "nan"),
        ([1, "a", 0, 0], "state = 'a' must be a number"),
        ([1, [2], 0, 0], "state = [2] must be a number"),
    ],
    "phase": [("a", "phase = 'a' must be a number"), (NAN, "phase = nan"), (7.0, "phase = 7.0")],
    "want": [
        ("section", "want = 'section' must be a list"), ([], "empty request; allowed: section"),
        (["enrgy"], "unknown want 'enrgy'; did you mean 'energy'"), ([3], "unknown want 3"),
        (["energy", "energy"], "names something twice"),
    ],
    "signals": [
        *no_list, (np.array(["x1", "x2"]), "must be a list of words"),
        ([1], "signals = [1] must be a list of words"),
    ],
    "signal": [
        (3, "signal = 3 must be a list"), ([1.5], "signal: 1.5 must be a text or a whole number"),
    ],
    "windows": [
        (3, "windows = 3 must be a list of pairs [begin, end]"),
        (["a:b"], "windows = 'a:b' must be BEGIN:END, two numbers of forcing periods"),
        ([100], "windows = 100 must be BEGIN:END"), ([[9, 5]], "end of windows = 5"),
    ],
    "panels": [
        (["forces"], "unknown panels 'forces'; did you mean 'force'"), ([], "empty"),
        (["force", "force"], "names something twice"),
        (np.array(["force"]), "must be a list of words"),
    ],
    "show": [
        (3, "show = 3 must be a list of words"), ([], "empty request; allowed: E1max"),
        (["x1max"], "unknown show 'x1max'; did you mean 'x1_max'"),
        (["E1max", "E1max"], "names something twice"),
    ],
    "heights": [
        ("tall", "heights = 'tall' must be a number"), ([], "must have a height for each storey"),
        ({"roof": -1.0}, "heights = -1.0 must be between 0 and"),
    ],
    "beside": [(3, "beside = 3 must be a list"), (["tuned"], "unknown beside 'tuned'")],
    "suite": [
        (3, "suite = 3 must be paths or tables of records"),
        ([], "suite = [] must be one or more records"),
        ({"file": [3]}, "file = 3 must be the path of a record"),
    ],
    "scale_to": [
        ("height=1", "unknown key 'height'"), (3, "scale_to = 3 must be a table"),
        ("peak=much", "peak = 'much' must be a number with a unit"), ({"Sa": 1.0}, "Sa needs T"),
    ],
    "parameters": [("k2", "must be two names"), (["k2"], "must be two names")],
    "states": [*no_list, ([1], "state = 1 must be a list of numbers")],
    "values": [*no_list, (["x"], "value = 'x' must be a number"), ([NAN], "value = nan")],
    "periods": [*no_list, ([0.5], "period = 0.5 must be a whole number from 1 to 1000000")],
    "of": [*no_list, ([1.5], "of: 1.5 must be a text or a whole number")],
    "on": [
        (3.5, "on: 3.5 must be a text or a whole number"),
        ({"a": "b"}, "on.a = 'b' must be a number"),
    ],
    "impulse": [(1e16, "impulse = 1e+16; allowed"), (NAN, "impulse = nan must be a finite number")],
    **{kind: [(3, f"{kind} = 3 must be a table"), ({}, "is missing")] for kind in ALL},
}  # fmt: skip
"""Wrong values of settings that a function checks, by key, with the expected message."""


def wrong_values(setting):
    key, check = setting.key, setting.check
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


@every_kind
def test_a_wrong_value_or_table_is_refused_with_its_place_and_what_is_allowed(kind, here, error_of):
    """The value stands in a document, in a file, or in changes to a document."""
    one = KINDS[kind]
    one.read(one.least)  # otherwise every refusal below could have another cause
    for setting in one.settings:
        others = one.least.get(setting.table, {})
        cases = [(setting.key, value, words) for value, words in wrong_values(setting)]
        misspelled = f"{setting.key}x" if len(setting.key) > 2 else 2 * setting.key
        words = f"did you mean '{setting.key}'"
        cases += [(misspelled, 1, f"unknown key '{misspelled}'; {words}")]
        for key, value, words in cases:
            wrong = {setting.table: {**others, key: value}}
            lines = {f"{kind}: ": error_of(one.read, {**one.least, **wrong})}
            changes = {setting.table: {key: value}}
            lines["keywords: "] = error_of(one.read, one.least, changes, "keywords")
            if isinstance(value, int | float | str):
                with suppress(ValueError):  # of texts and numbers that no file can hold
                    Path("r.toml").write_text(toml_text({**one.least, **wrong}))
                    lines["r.toml: "] = error_of(one.read, "r.toml")
            for place, line in lines.items():
                assert line.startswith(place), line
                assert f"[{setting.table}]: " in line, line
                assert words in line
    # an unknown table, and a value that is not a table
    for name, table in one.form.tables.items():
        line = error_of(one.read, {**one.least, f"{name}x": {}})
        assert f"unknown key '{name}x'; did you mean '{name}'" in line
        line = error_of(one.read, {**one.least, name: 3})
        assert f"{kind}: [{name}]: {name} = 3 must be a table" in line
        assert table or name in (*one.form.names, *one.form.whole)


NOT_NUMBERS = {
    "1_0": "in the digits 0 to 9, without _", "٣": "in the digits 0 to 9", "0x10": "'0x10'",
    "ten": "'ten'", "": "''", "1" * 5000: "must be a",
}  # fmt: skip
"""Texts that are not numbers, with the expected message."""


def wrong_texts(setting):
    key, wrong = setting.key, wrong_values(setting)
    match setting.check:
        case Whole(low, high):
            outside = [(str(n), f"{key} = {n} must be a whole number") for n in (low - 1, high + 1)]
            return [*outside, ("2.5", "must be a whole number"), *NOT_NUMBERS.items()]
        case Real():
            return [("nan", f"{key} = nan"), ("1e10", f"{key} = 1"), *NOT_NUMBERS.items()]
        case Truth() | Text():
            return []
        case Checked(listed=True):
            lists = [(value, words) for value, words in wrong if isinstance(value, list)]
            return [(",".join(v), words) for v, words in lists if {*map(type, v)} <= {str}]
    return [(v, words) for v, words in wrong if isinstance(v, str) and not v[0].isdigit()]


@every_kind
def test_an_option_is_refused_in_its_own_words(kind, here, answer, refusal):
    command, *usual = KINDS[kind].command.split()
    has_more = "--help-all" in answer(command, "--help")
    listed = answer(command, "--help-all" if has_more else "--help")
    for setting in KINDS[kind].settings:
        if not (setting.has_option and setting.flag in listed):
            continue
        for text, words in wrong_texts(setting):
            err = refusal(command, *usual, f"{setting.flag}={text}")
            assert words in err
            in_a_table = "command line: " in err and f"[{setting.table}]: " in err
            assert setting.flag in err or in_a_table
    assert list(here.iterdir()) == []


# ---- one document, one hash ----------------------------------------------------------------------

RANGE = {"omega": {"start": 6.0, "stop": 7.0, "num": 3}}
SAME = {
    "scan": [
        {**SET6, "vary": RANGE},
        {"vary": {"omega": {"values": [6, 6.5, 7]}}, **SET6},
        {**SET6, "vary": RANGE, "sampling": {"transient": 600, "tolerance": "standard"}},
        {**SET6, "vary": RANGE, "start": {"policy": "rest"}, "title": "another title"},
    ],
    "tuning": [
        {**SET6, "free": {"k2": {}, "c2": {}, "C": {}}},
        {**SET6, "free": {"C": {}, "c2": {}, "k2": {"low": 10, "high": 1e4}}},
        {
            **SET6,
            "free": {"c2": {}, "k2": {}, "C": {}},
            "search": {"seed": 0, "objective": "E1max"},
        },
    ],
    "continuation": [SET6, {**SET6, "along": {"omega": {"start": 5, "stop": 9}}, "start": {}}],
    "portrait": [SET6, {**SET6, "sampling": {"periods": 240}}, {**SET6, "column": [{}]}],
    "response history": [
        {"systems": ["tmd"], "load": {"impulse": 1}},
        {"system": "tmd", "load": {"impulse": 1.0, "scale": 1.0}, "sampling": {"duration": 60}},
    ],
}
"""Documents of each kind that mean the same."""


@pytest.mark.parametrize("kind", SAME)
def test_what_means_the_same_has_one_hash(kind, here):
    """In another order, with defaults written out, from documents, files and keywords."""
    one, hashes = KINDS[kind], set()
    for document in SAME[kind]:
        Path("r.toml").write_text(toml_text(document))
        system = document.get("system", "tmd")
        bare = {"system": system}
        for sources in ((document,), ("r.toml",), (system, document), (bare, document)):
            request = one.read(*sources)
            hashes.add(request.hash)
            assert one.read(request.document()).hash == request.hash
    assert len(hashes) == 1


def test_what_the_changes_vary_is_set_no_longer():
    document = {**SET6, "set": {"omega": 6.9, "zeta1": 0.02}}
    for vary in (RANGE, {"f": {"values": [6 / 2 / np.pi]}}):
        varied = nv.load_scan({**document, "vary": {"P": {"values": [1.0]}}}, {"vary": vary})
        alone = nv.load_scan({**SET6, "set": {"zeta1": 0.02}, "vary": vary})
        assert varied.hash == alone.hash
    system = nv.load_system("ssul-set6")
    assert nv.load_scan({"system": system, "vary": RANGE}) == nv.load_scan({**SET6, "vary": RANGE})


def test_an_override_removes_the_entries_it_replaces():
    scan = {**SCAN, "start": {"policy": "random", "count": 4, "seed": 1}}
    start = nv.load_scan(scan, {"start": {"policy": "random", "count": 8}}).start
    assert (start.count, start.seed) == (8, 1)
    assert nv.load_scan(scan, {"start": {"policy": "up"}}).start.count == 1
    assert nv.load_scan(scan, {"start": {"state": [0.1, 0, 0, 0]}}).start.policy == "state"
    scan["start"] = {"state": [0.1, 0.0, 0.0, 0.0]}
    assert nv.load_scan(scan, {"start": {"policy": "rest"}}).start.state == ()


# ---- one file for every command ------------------------------------------------------------------

FILE = """
title = "My damper"
system = "ssul-set6"
set = { P = 850 }
vary = { omega = { start = 7.0, stop = 7.5, num = 3 } }
start = { policy = "random", count = 4, seed = 1 }
sampling = { transient = 333, periods = 77, nodes = 6 }
record = { want = ["energy"] }
"""


@pytest.fixture
def scan(here):
    Path("scan.toml").write_text(FILE)
    return "scan.toml"


def test_all_keys_of_files_are_known():
    forms = [one.form for one in KINDS.values()]
    keys = {*settings.MARKS, *settings.SHARED, *settings.LENT}
    assert {key for form in forms for key in form.keys} == keys == {*catalog.FILE_KEYS}
    for name, known in settings.KEYS_OF.items():
        assert {key for form in forms for key in form.tables.get(name, {})} == known


OF_EVERY_TASK = """
title = "My damper"
system = "ssul-set6"
set = { P = 700.0, m2 = 61.0 }
start = { policy = "rest" }
sampling = { transient = 50, periods = 20 }
record = { want = ["energy", "regime"] }
vary = { C = { start = 0.05, stop = 0.07, num = 5 } }
load = { half_sine = { peak = 500.0, length = 0.2 } }
free = { k2 = { low = 100.0, high = 3000.0 } }
search = { objective = "E1max" }
along = { omega = { start = 5.0, stop = 7.0 } }
figure = { log = true }
"""

LEFT = {
    "bifurcation": "[load], [free], [search], [along], [figure]",
    "response-curves": "[load], [free], [search], [along]",
    "portrait": "[start], [record], [vary], [load], [free], [search], [along], [figure]",
    "continuation": "[record], [vary], [load], [free], [search], [figure], [sampling]",
    "tuning": "[start], [record], [vary], [along], [figure]",
    "transients": "[start], [record], [vary], [load], [free], [search], [along], [figure]",
    "response-history": "[start], [record], [free], [search], [along], [figure], "
    "transient of [sampling], periods of [sampling]",
}


@pytest.mark.parametrize("command", LEFT)
def test_one_file_serves_all_commands_and_what_is_left_aside_is_named(command, here, ask):
    Path("all.toml").write_text(OF_EVERY_TASK)
    printed = ask(command, "all.toml", "--dry-run")
    assert printed.err == f"nlds-vines {command}: all.toml: left aside here: {LEFT[command]}\n"
    if command in ("bifurcation", "transients"):
        assert "m2 = 61" in printed.out
    if command in ("bifurcation", "response-curves", "response-history"):
        assert "C = 0.05 to 0.07" in printed.out
    if command in ("bifurcation", "response-curves", "transients"):
        assert "50 + 20 each" in printed.out


@pytest.mark.kernels
def test_a_system_is_read_from_any_request_file(here):
    Path("all.toml").write_text(OF_EVERY_TASK)
    system = nv.load_system("all.toml")
    assert (system.parameters["P"], system.parameters["m2"]) == (700.0, 61.0)
    with pytest.warns(LeftAside):
        lifetimes = nv.transient_lifetimes("all.toml", starts=3, quiet=True)
    assert (lifetimes.request.transient, lifetimes.request.periods) == (50, 20)


@pytest.mark.parametrize("command", ["portrait", "tuning", "continuation"])
def test_a_file_lends_what_all_kinds_have(command, scan, ask):
    printed = ask(command, scan, "--dry-run")
    assert printed.out.startswith("My damper\n")
    assert printed.err.count("\n") == 1
    assert "scan.toml: left aside here: [vary], [start], [record]" in printed.err
    assert ask(command, scan, "--dry-run", "--quiet").err == ""


def test_a_file_lends_its_sampling_and_its_title(scan):
    with pytest.warns(LeftAside, match="nodes of"):
        portrait = load_portrait(scan)
    assert portrait.columns[0].window == (333, 410)
    assert portrait.columns[0].system.parameters["P"] == 850
    with pytest.warns(LeftAside):
        tuning = nv.load_tuning(scan)
    assert (tuning.transient, tuning.periods) == (333, 77)
    lines = [line for line in FILE.splitlines() if not line.startswith("start")]
    Path(scan).write_text("\n".join([*lines, 'portrait = { panels = ["energy"] }']))
    with pytest.warns(LeftAside, match="vary"):
        assert load_portrait(scan).panels == ("energy",)
    # the title of a file stays, and that of the default does not
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", LeftAside)
        for load in (nv.load_scan, nv.load_tuning, nv.load_continuation):
            assert load(scan, {"set": {"P": 900.0}}).title == "My damper"
    assert "Figure 8" not in nv.load_scan(None, {"set": {"P": 900.0}}).title


@pytest.mark.parametrize("path", sorted(SCANS.glob("*.toml")), ids=lambda path: path.stem)
@pytest.mark.parametrize("command", ["portrait", "tuning", "continuation"])
def test_all_files_serve_all_commands(command, path, capsys, here):
    status = main([command, str(path), "--dry-run"])
    err = capsys.readouterr().err
    assert "unknown key" not in err
    # the file of response curves names a system in each curve; some systems have no damper to tune
    assert status == 0 or any(words in err for words in ("system", "damper", "nothing is free"))


# ---- what may vary -------------------------------------------------------------------------------

LOADS = {
    "blow": {"impulse": 1.0, "repeat": 2, "every": 1.0},
    "record": {"values": [0.0, 1.0, 0.0], "dt": 0.01},
    "tone": {"amplitude": 1.0, "omega": 3.0},
    "sweep": {"amplitude": 1.0, "first": 3.0, "last": 5.0, "length": 9.0},
    "noise": {"rms": 1.0, "high": 20.0},
    **{kind: {"peak": 1.0, "length": 0.1, "repeat": 2, "every": 1.0}
       for kind in ("half_sine", "triangular", "rectangular", "friedlander")},
}  # fmt: skip
NUMBERS_OF_LOADS = [
    *(("impulse", "scale")),
    *(f"{kind}.{setting.key}" for kind in ALL for setting in settings_of(ALL[kind]).values()),
]
RANGES = ([-1.0, 0.0, 1.0], [1.0, 1.5, 2.0], [2.0, 3.0, 4.0], [0.0, 0.5, 1.0], [19.0, 20.0, 21.0])
"""Axes whose ends many settings allow, but not every value in between."""


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
@pytest.mark.parametrize(("read", "key"), [(load_response_history, "vary"), (load_tuning, "over")])
def test_a_value_within_an_axis_of_a_load_is_refused(read, key, name, values, words, error_of):
    kind = name.partition(".")[0]
    document = {"load": {kind: LOADS[kind]}, key: {name: {"values": values}}}
    assert words in error_of(read, "tmd", document)


def test_texts_that_are_no_number_and_uncertain_whole_numbers_are_refused(here, refusal, error_of):
    assert "'a' must be a number" in refusal("response-history", "--impulse=1", "--start=1,a,0,0")
    assert "'a' must be a number" in refusal("tuning", "--impulse=1", "--start=1,a,0,0")
    assert "'²'" in refusal("response-history", "--load=blow:impulse=²")
    assert "must be a" in refusal("response-history", f"--load=blow:impulse={'1' * 5000}")
    tables = {"load": {"blow": LOADS["blow"]}, "uncertain": {"blow.repeat": 1.0}}
    assert "blow.repeat is a whole number" in error_of(load_tuning, "tmd", tables)
    load = {"friedlander": LOADS["friedlander"]}
    tables = {"load": load, "uncertain": {"friedlander.unit": "5%"}}
    assert "friedlander.unit = 'N' must be a number" in error_of(load_tuning, "tmd", tables)
