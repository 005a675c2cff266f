"""A copy of the checkout in which mutants are tried: the checkout itself is never changed."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import time
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path

from benchmarks.mutants.mutant import Mutant

KILLED, SURVIVED, TIMED_OUT, BROKEN = "killed", "survived", "killed (time out)", "broken"

COPIED = ("nlds_vines", "benchmarks", "tests", "data", "scans", "docs", "pyproject.toml")
"""What the tests of a mutant need of a checkout."""

LONGEST = 300.0
"""Time [s] of the tests of one mutant: a loop that never ends is noticed, too."""

PASSED, FAILED = 0, 1
"""Exit statuses of pytest where tests ran: all passed, one failed."""


class BaselineError(RuntimeError):
    """The tests cannot tell mutants: they fail, or do not run, without any change."""


@dataclass(frozen=True)
class Outcome:
    """What became of one mutant."""

    mutant: Mutant
    verdict: str
    seconds: float
    words: str = ""  # of what did not go as it should

    @property
    def noticed(self) -> bool:
        """Tell whether all tests of the mutant noticed it."""
        return self.verdict in (KILLED, TIMED_OUT)


class Trial:
    """A copy of a checkout in a folder of its own."""

    def __init__(self, checkout: Path, folder: Path) -> None:
        """Copy what the tests need."""
        self.folder = folder.resolve()
        ignored = shutil.ignore_patterns("__pycache__", "*.nbi", "*.nbc", "archives")
        for name in COPIED:
            source, target = checkout / name, self.folder / name
            if source.is_dir():
                ignore = ignored if name == "docs" else shutil.ignore_patterns("__pycache__")
                shutil.copytree(source, target, ignore=ignore)
            else:
                shutil.copy(source, target)

    def baseline(self, mutants: Iterable[Mutant]) -> None:
        """Raise `BaselineError` unless the tests pass on the unchanged copy."""
        tests = sorted({test for mutant in mutants for test in mutant.tests})
        status, text = self._pytest(tests, None)
        if status != PASSED:
            raise BaselineError(f"the tests do not pass without a change: {_reason(text)}")

    def outcome(self, mutant: Mutant) -> Outcome:
        """Return what the tests of a mutant say of the copy with its change."""
        path = self.folder / mutant.file
        sound = path.read_text(encoding="utf-8")
        path.write_text(mutant.applied_to(sound), encoding="utf-8")
        began = time.perf_counter()
        try:
            verdict, words = self._verdict(mutant)
        finally:
            path.write_text(sound, encoding="utf-8")
        return Outcome(mutant, verdict, time.perf_counter() - began, words)

    def _verdict(self, mutant: Mutant) -> tuple[str, str]:
        """Return a verdict on the mutant in the copy, and words for what is not as it should be."""
        verdict = KILLED
        for test in mutant.tests:
            try:
                status, text = self._pytest(["-x", test], LONGEST)
            except subprocess.TimeoutExpired:
                verdict = TIMED_OUT
                continue
            if status == PASSED:
                return SURVIVED, f"not noticed by {test}"
            if status != FAILED:
                return BROKEN, _reason(text)
        return verdict, ""

    def _pytest(self, tests: Sequence[str], limit: float | None) -> tuple[int, str]:
        """Run tests in the copy; return pytest's exit status and what it printed.

        Kernels run as plain Python, equal to the last bit: a change would be compiled for a minute.
        """
        options = ["-p", "no:cacheprovider", "-o", "addopts=", "-q", "-rfE", "--tb=no"]
        options += ["-W", "ignore::RuntimeWarning"]  # NumPy warns where compiled kernels do not
        found = subprocess.run(
            [sys.executable, "-m", "pytest", *options, *tests],
            cwd=self.folder, env=self._environment(), timeout=limit,
            stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, check=False,
        )  # fmt: skip
        return found.returncode, found.stdout

    def _environment(self) -> dict[str, str]:
        """Return the environment of the tests: the copy is imported, and nothing is kept."""
        kept = {n: v for n, v in os.environ.items() if not n.startswith(("NUMBA_", "PYTEST_"))}
        own = {"PYTHONPATH": str(self.folder), "PYTHONDONTWRITEBYTECODE": "1", "COLUMNS": "1000"}
        return kept | own | {"NUMBA_DISABLE_JIT": "1"}


def _reason(text: str) -> str:
    """Return the line in which pytest says what failed or why it ran no test, else its last one."""
    lines = [line for line in text.splitlines() if line.strip()]
    telling = (line for line in lines if line.startswith(("ERROR", "FAILED")))
    return next(telling, (lines or ["no output"])[-1])
