"""A thousand requests that no one means, of each entry: command line, file, Python, page.

Whatever is asked, an error is one line, no file is changed, and it takes ten seconds at most.
"""

import contextlib
import io
import random
import time
import tomllib
import traceback
from importlib import import_module
from pathlib import Path

import numpy as np
import pytest
from commands import contents
from made_up import MAP, make_scan, write

import nlds_vines as nv
from nlds_vines.__main__ import COMMANDS, main
from nlds_vines.archives.files import read_toml, toml_text
from nlds_vines.cli.options import Parser

pytestmark = pytest.mark.long

CASES = 1000
SECONDS = 10.0  # CPU time of one of them

STRANGE = (
    "", "-", "--", "=", "a=", "=b", "nan", "inf", "-0", "1e999", "9" * 5000, "1_000", "0x10", "٣",
    "a\0b", "\udcff", "\n", "x" * 3000, "[", "{", ",", ":", "1:2", "1:2:3", "1:2:1e9", "omega",
    "omega=1:2:3", "omega=nan:2:3", "omega=1:2:99999999999", "P=nan", "P=1,omega=2", "/", "..",
    "/dev/zero", "True", "None", "rest", "random:0", "all", "1/0", "2/1", "slurm", "local:0", "?",
    "a.h5", "b.toml", "chaos", "T,1", "0T,0",
)  # fmt: skip
"""Texts that an option may be given."""

VALUES = (
    None, True, 7, -1, 0, 2.5, float("nan"), float("inf"), 10**400, 1e300, "", "word", "a\0b",
    "x" * 2000, [], [1], ["a"], [[]], [None], {}, {"a": 1}, {"start": 1, "stop": 2, "num": 3},
)  # fmt: skip
"""What may stand in place of a value."""

WRONG_TYPE = (TypeError, AttributeError, ValueError, LookupError, ArithmeticError)
"""What Python may raise for an argument of another type than a function takes."""


def broken_by(ask, folder):
    """Return in words how a question breaks the rule; `ask` returns a status and the errors."""
    before, began = contents(folder), time.process_time()
    try:
        with contextlib.redirect_stdout(io.StringIO()):
            status, errors = ask()
    except BaseException:
        return traceback.format_exc()
    took, after = time.process_time() - began, contents(folder)
    wrong = {
        f"status {status}": status not in (0, 1, 2),
        f"lines: {errors[:500]!r}": status == 2 and len(errors.splitlines()) != 1,
        errors[-500:]: "Traceback" in errors,
        f"{took:.1f} s": took > SECONDS,
        "a file is changed": any(after.get(name) != data for name, data in before.items()),
        "files are left": status == 2 and bool(after.keys() - before.keys()),
    }
    return "; ".join(words for words, is_wrong in wrong.items() if is_wrong)


def command(words):
    errors = io.StringIO()
    with contextlib.redirect_stderr(errors):
        status = main(words)
    return status, errors.getvalue()


def assert_none_is_broken(here, seed, question):
    """Try questions, each (its words, a function that asks); remove the files that they leave."""
    rng, wrong, files = random.Random(seed), [], set(here.iterdir())
    for number in range(CASES):
        words, ask = question(rng)
        if broken := broken_by(ask, here):
            wrong.append(f"case {number}: {words!r:.300}: {broken}")
        for path in set(here.iterdir()) - files:
            path.unlink()
    assert not wrong, "\n".join(wrong)


USUAL = {
    "report": ["a.h5", "-o", "p.html"], "rerun": ["a.h5", "-o", "r.h5", "--dry-run"],
    "export": ["a.h5", "-o", "c.csv"], "plot": ["a.h5", "--show", "?"],
    "explore": ["a.h5", "--port", "0", "--dry-run"],
}  # fmt: skip
"""Words with which a command computes nothing, where these are not `--dry-run` alone."""


def line(rng):
    name = rng.choice(sorted(COMMANDS))
    words, parser = list(USUAL.get(name, ["--dry-run"])), Parser(prog=name)
    import_module(COMMANDS[name][0]).main.__self__.declare(parser)
    actions = [each for each in parser._actions if "--help" not in each.option_strings]
    for action in rng.choices(actions, k=rng.randint(1, 3)) if actions else ():
        value = rng.choice(STRANGE)
        if not action.option_strings:
            words.insert(0, value)
        elif action.nargs == 0:
            words.append(rng.choice([action.option_strings[-1], f"--{value}"]))
        else:
            option = action.option_strings[-1]
            words += rng.choice([[option, value], [f"{option}={value}"]])
    return [name, *words], lambda: command([name, *words])


def test_no_command_line_breaks_the_rule(here):
    write(here / "a.h5", make_scan(("energy", "regime"), vary=MAP))
    assert_none_is_broken(here, 1, line)


FILES = sorted((Path(__file__).parents[2] / "scans").glob("*.toml"))
READERS = ("bifurcation", "portrait", "tuning", "continuation", "response-curves")


def tables(document):
    tables_in = [document]
    for value in document.values():
        for each in value if isinstance(value, list) else [value]:
            tables_in += tables(each) if isinstance(each, dict) else []
    return tables_in


def damaged(rng, text):
    """Return the text of a file with a key lost, misspelled or given another value, or cut."""
    document = tomllib.loads(text)
    entries = rng.choice(tables(document))
    key = rng.choice(sorted(entries) or ["x"])
    match rng.randrange(4):
        case 0:
            entries[key] = rng.choice([value for value in VALUES if value is not None])
        case 1:
            entries.pop(key, None)
        case 2:
            entries[rng.choice(["x", key[::-1], key.upper(), "a b", "é"])] = entries.get(key, 1)
        case _:
            first, last = sorted(rng.sample(range(len(text) + 1), 2))
            odd = rng.choice(["", "\0", "\n", "[", "]]", '"', "=", "é", "nan", "1e999", "#"])
            return text[:first] + odd + text[rng.choice([first, last]) :]
    with contextlib.suppress(TypeError, ValueError, OverflowError):
        return toml_text(document)
    return text


def test_no_request_breaks_the_rule(here):
    assert len(FILES) > 30
    assert all(read_toml(path) for path in FILES)

    def question(rng):
        path, name = rng.choice(FILES), rng.choice(READERS)
        text = damaged(rng, path.read_text())
        Path("r.toml").write_text(text, encoding="utf-8", errors="surrogateescape")
        return (name, path.name, text), lambda: command([name, "r.toml", "--dry-run", "--quiet"])

    assert_none_is_broken(here, 2, question)


ODD = (
    *VALUES, b"bytes", (), (1, 2), {1: 2}, set(), range(3), object(), len, int, 1j, np.float64(1),
    np.zeros(3), np.zeros((2, 2)), np.array(["a"]), "ssul-set6", "a.h5", "/", ("a", "b", "c"),
)  # fmt: skip

CALLS = {
    "load_system": ["P", "K", "omega", "law", "e"],
    "load_scan": ["changes", "changes_from"],
    "load_tuning": ["changes", "changes_from"],
    "load_continuation": ["changes", "changes_from"],
    "read": [],
    "plot": ["show"],
    "basin_measures": [],
    "orbit_of": ["omega", "P", "start"],
    "spectrum": ["signal"],
}
"""What computes nothing with a value that is not allowed, and its keywords."""


def call(rng):
    name, value = rng.choice(sorted(CALLS)), rng.choice(ODD)
    keywords = {key: rng.choice(ODD) for key in CALLS[name] if rng.random() < 0.4}

    def ask():
        try:
            getattr(nv, name)(value, **keywords)
        except nv.RequestError as error:
            return 2, str(error)
        except WRONG_TYPE:
            return 1, ""
        return 0, ""

    return (name, value, keywords), ask


def test_no_call_breaks_the_rule(here):
    write(here / "a.h5", make_scan(("energy", "regime"), vary=MAP))
    assert_none_is_broken(here, 4, call)


CALLBACKS = ("press", "set_value", "slide", "choose", "refine")


@pytest.fixture
def page(here, monkeypatch):
    """A page that shows what is wrong, and computes nothing."""
    pytest.importorskip("bokeh", reason="Bokeh is not installed")
    from bokeh.document import Document

    from nlds_vines.explore import live_orbit, page_state
    from nlds_vines.explore.live_page import Page
    from nlds_vines.explore.map_data import stored
    from nlds_vines.explore.page_state import Opened

    monkeypatch.setattr(live_orbit, "live_orbit", lambda *_: None)
    monkeypatch.setattr(page_state.Refining, "start", lambda _: None)
    page = Page(Document(), Opened(stored(write(here / "a.h5", make_scan(vary=MAP)))))
    page.later = lambda *_: None
    yield page
    page.close()


def test_nothing_that_a_browser_sends_ends_a_page(page, here):
    def question(rng):
        name, values = rng.choice(CALLBACKS), [rng.choice([*VALUES, *STRANGE]) for _ in range(2)]

        def ask():
            page.say_trouble("")
            page.guarded(
                getattr(page, name), *values[: 1 + (name in ("set_value", "slide", "refine"))]
            )
            return (2, page.trouble.text) if page.trouble.text else (0, "")

        return (name, values), ask

    assert_none_is_broken(here, 5, question)
