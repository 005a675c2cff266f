"""What holds whatever is asked: one line for an error, no file changed, ten seconds at most."""

import contextlib
import hashlib
import io
import time
import traceback
from pathlib import Path

from nlds_vines.__main__ import main
from nlds_vines.errors import RequestError

CASES = 1000
"""How many a test tries."""

SECONDS = 10.0
"""CPU time that one of them may take."""

STATUSES = (0, 1, 2)

STRANGE = (
    "", "-", "--", "=", "a=", "=b", "nan", "inf", "-inf", "-0", "1e999", "9" * 5000, "1_000",
    "0x10", "٣", "a\0b", "\udcff", "\n", "x" * 3000, "[", "{", ",", ":", "1:2", "1:2:3", "::",
    "1:2:1e9", "omega", "omega=", "omega=1:2:3", "omega=nan:2:3", "omega=1:2:-3",
    "omega=1:2:99999999999", "P=--", "P=nan", "P=1,omega=2", "/", ".", "..", "/dev/null",
    "/dev/zero", "/proc/self/mem", "True", "None", "rest", "random", "random:0", "all", "1/0",
    "2/1", "slurm", "local:0", "?", "tcp://a:0", "a.h5", "b.toml", "no.h5", "chaos", "T,1",
    "0T,0",
)  # fmt: skip
"""Texts that an option may be given."""

VALUES = (
    None, True, 7, -1, 0, 2.5, float("nan"), float("inf"), 10**400, 1e300, "", "word", "a\0b",
    "x" * 2000, [], [1], ["a"], [[]], [None], {}, {"a": 1}, {"start": 1, "stop": 2, "num": 3},
)  # fmt: skip
"""What may stand in place of a value."""


def files(folder):
    """Return what is in a folder: the digest of each file by its path."""
    paths = (path for path in Path(folder).rglob("*") if path.is_file())
    return {str(path): hashlib.sha256(path.read_bytes()).hexdigest() for path in paths}


def broken_by(ask, folder, lines=1):
    """Return in words how a question breaks the rule, '' where it does not.

    `ask` returns a status and what was written to the standard error; of several files, each may
    have one of so many `lines`.
    """
    before, began = files(folder), time.process_time()
    try:
        status, errors = ask()
    except BaseException:
        return traceback.format_exc()
    took, after = time.process_time() - began, files(folder)
    wrong = []
    if status not in STATUSES:
        wrong.append(f"status {status}")
    if status == 2 and not 1 <= len(errors.splitlines()) <= lines:
        wrong.append(f"{len(errors.splitlines())} lines: {errors[:500]!r}")
    if "Traceback" in errors:
        wrong.append(errors[-500:])
    if took > SECONDS:
        wrong.append(f"{took:.1f} s")
    if any(after.get(path) != digest for path, digest in before.items()):
        wrong.append("a file is changed or lost")
    if status == 2 and set(after) - set(before):
        wrong.append(f"it leaves {sorted(set(after) - set(before))}")
    return "; ".join(wrong)


def command(words):
    """Return a question: a command in this process."""

    def ask():
        output, errors = io.StringIO(), io.StringIO()
        with contextlib.redirect_stdout(output), contextlib.redirect_stderr(errors):
            status = main(words)
        return status, errors.getvalue()

    return ask


def call(function, *arguments, **keywords):
    """Return a question: a function of Python, which may raise `RequestError` alone."""

    def ask():
        try:
            with contextlib.redirect_stdout(io.StringIO()):
                function(*arguments, **keywords)
        except RequestError as error:
            return 2, str(error)
        return 0, ""

    return ask


def short(given):
    """Return what was given, cut to a line."""
    return repr(given)[:300]
