"""The gate: what the README and the tutorial tell a reader to do, word for word, and all checks.

    .ci/run                  all of it
    .ci/run kernels          ... the tests of kernels alone, with what they need
    .ci/run others           ... everything else: two machines share the gate by these words

It clones HEAD into an empty folder and runs the sections below there, each as soon as those that it
waits for have passed; so the site is built beside the tests. The output of a section is shown when
it ends, with its seconds. The gate stops at the first failure, and its last lines then name the
tests that failed and the commands that repeat them; otherwise they name the seconds of all sections
and what costs most in them. It needs Python 3.11 or newer as `python3`, git, and a package index.
Pages in a browser are tested where a Chromium is installed.

Kernels are compiled in the environment of the README's first command, as a reader sees it, and by
the lowest versions. Tests and site, whose package is that of the clone, and the wheel begin with
copies of what the first command has compiled; the tutorial has copies of what they have compiled.
If GATE_KERNELS names a folder, the tests of kernels alone begin with the kernels in it, which are
replaced by those of the clone when they pass. Each is stamped with its sources, so none is out of
date. The default tests never begin so: they would not notice what they compile.
"""

from __future__ import annotations

import json
import os
import re
import shlex
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path
from typing import NamedTuple, NoReturn

CHECKOUT = Path(__file__).resolve().parents[1]

OURS = ("PYTHONPATH", "PYTHONHOME", "VIRTUAL_ENV")
OURS += ("NUMBA_CACHE_DIR", "NUMBA_DISABLE_JIT", "NUMBA_NUM_THREADS")
"""Variables of a developer's shell that no section sees."""

PYTEST = ".venv-dev/bin/python -m pytest -n 0 -m ''"
PLAIN = f"NUMBA_DISABLE_JIT=1 {PYTEST}"
"""Commands that run a test of any tier by its name, in a checkout made as CONTRIBUTING.md tells."""

BROWSER = """
found() { command -v chromium chromium-browser google-chrome chrome | head -n 1 || true; }
browser=$(found)
if [ -z "$browser" ] && [ "$(id -u)" -eq 0 ] && command -v apt-get >/dev/null; then
    { apt-get update -qq && apt-get install -qq -y chromium; } >/dev/null 2>&1 || true
    browser=$(found)
fi
echo "browser: ${browser:-none, so tests in a browser are skipped}"
"""

FIRST = """
.ci/walk.py README.md:1-2
for file in figure8.h5 figure8.png heavier.h5 heavier.png; do
    [ -s "$file" ] || { echo "the commands of the README left no $file"; exit 1; }
done
mkdir -p nlds_vines/kernels/__pycache__
cp .venv/lib/python3*/site-packages/nlds_vines/kernels/__pycache__/*.compiled \\
    nlds_vines/kernels/__pycache__/
"""

SITE = """
.ci/walk.py README.md:5
[ -s docs/_build/html/index.html ] || { echo "the commands of the README left no site"; exit 1; }
"""

STYLE = """
.venv-test/bin/ruff check .
.venv-test/bin/ruff format --check .
.venv-test/bin/mypy
"""

# with the libraries of the first environment, from a folder without the clone
WHEEL = """
.venv/bin/python -m pip wheel --quiet --no-deps --wheel-dir "$WORK/wheel" .
python3 -m zipfile -l "$WORK"/wheel/*.whl >"$WORK/wheel.txt"
if grep -E "benchmarks|paper/|tests/" "$WORK/wheel.txt"; then
    echo "the wheel carries what only measures"; exit 1
fi
grep -q "nlds_vines/py.typed" "$WORK/wheel.txt" || { echo "the wheel carries no types"; exit 1; }
.venv/bin/python -m pip install --quiet --no-deps --target "$WORK/site" "$WORK"/wheel/*.whl
mkdir -p "$WORK/site/nlds_vines/kernels/__pycache__" "$WORK/empty"
cp .venv/lib/python3*/site-packages/nlds_vines/kernels/__pycache__/*.compiled \\
    "$WORK/site/nlds_vines/kernels/__pycache__/"
cd "$WORK/empty"
PYTHONPATH="$WORK/site" "$OLDPWD/.venv/bin/python" -m nlds_vines.bifurcation \\
    --vary omega=6:6.5:11 --transient 50 --periods 20
for file in figure8.h5 figure8.png; do
    [ -s "$file" ] || { echo "the installed wheel left no $file"; exit 1; }
done
"""

# the README's first program, whose archive must be that of the newest versions, bit by bit
LOWEST = """
python3 -m venv .venv-lowest
.venv-lowest/bin/python -m pip install --quiet --no-compile $(.ci/lowest.py pyproject.toml)
mkdir -p "$WORK/lowest"
(cd "$WORK/lowest" && NUMBA_CACHE_DIR=$WORK/lowest/cache PYTHONPATH=$OLDPWD \\
    "$OLDPWD/.venv-lowest/bin/python" -m nlds_vines.bifurcation)
.venv/bin/python - figure8.h5 "$WORK/lowest/figure8.h5" <<'END'
import sys, h5py
one, other = (h5py.File(path) for path in sys.argv[1:])
assert set(one) == set(other), "the archives have other datasets"
for name in one:
    assert one[name][...].tobytes() == other[name][...].tobytes(), f"{name} differs"
END
"""

# in a folder of its own, so that nothing that it writes lies in the way of tests
TUTORIAL = """
cp nlds_vines/kernels/__pycache__/*.compiled \\
    .venv/lib/python3*/site-packages/nlds_vines/kernels/__pycache__/
mkdir -p "$WORK/reader"
ln -s "$PWD/.venv" "$WORK/reader/.venv"
page=$PWD/docs/tutorial.md
walk=$PWD/.ci/walk.py
cd "$WORK/reader"
"$walk" "$page"
"""


class Section(NamedTuple):
    """A part of the gate: commands of bash, begun when those that it waits for have passed."""

    name: str
    commands: str
    after: tuple[str, ...] = ()


KERNELS = "tests of kernels"
NEEDED = ("browser", "first commands of the README", "environment of the tests")
"""What the tests of kernels need where they run alone."""

# Environments first; then the default tests beside what is built and walked. The tests of kernels,
# of which some are ended within seconds, come last, when little else is left.
SECTIONS = (
    Section("browser", BROWSER),
    Section("first commands of the README", FIRST),
    Section("environment of the tests", ".ci/walk.py README.md:3"),
    Section(
        "default tests",
        ".ci/walk.py README.md:4",
        ("first commands of the README", "environment of the tests"),
    ),
    Section("style and types", STYLE, ("environment of the tests",)),
    Section("site", SITE, ("first commands of the README", "style and types")),
    Section("lowest versions", LOWEST, ("site",)),
    Section("wheel", WHEEL, ("lowest versions",)),
    Section("tutorial", TUTORIAL, ("wheel",)),
    Section(
        KERNELS,
        ".venv-test/bin/python -m pytest -m 'kernels and not long'",
        ("default tests", *NEEDED),
    ),
)


def sections_of(part: str) -> list[Section]:
    """Return the sections of a part of the gate, which wait for sections of that part alone."""
    chosen = {section.name for section in SECTIONS}
    if part == "kernels":
        chosen = {*NEEDED, KERNELS}
    elif part == "others":
        chosen -= {KERNELS}
    elif part:
        sys.exit(f"unknown part {part!r}; allowed: kernels, others")
    parts = [section for section in SECTIONS if section.name in chosen]
    return [s._replace(after=tuple(name for name in s.after if name in chosen)) for s in parts]


def copy_kernels(source: Path, target: Path) -> None:
    """Copy compiled kernels from one folder into another, in place of those that are there."""
    target.mkdir(parents=True, exist_ok=True)
    for path in target.glob("*.compiled"):
        path.unlink()
    for path in source.glob("*.compiled"):
        shutil.copy2(path, target)


def say(text: str) -> None:
    """Print a line with the seconds since the gate began."""
    print(f"== {time.monotonic() - BEGAN:5.0f} s  {text}", flush=True)


BEGAN = time.monotonic()


class Running:
    """A section under way, in a session of its own, whose output goes into a file."""

    def __init__(self, section: Section, clone: Path, work: Path) -> None:
        """Begin it."""
        self.section = section
        self.began = time.monotonic()
        self.log = work / "log" / section.name.replace(" ", "-")
        self.log.parent.mkdir(exist_ok=True)
        environment = {name: value for name, value in os.environ.items() if name not in OURS}
        environment["WORK"] = str(work)
        self.costs = self.log.with_suffix(".costs")
        environment["TEST_COSTS"] = str(self.costs)
        with self.log.open("wb") as file:
            self.process = subprocess.Popen(
                ["bash", "-euo", "pipefail", "-c", section.commands],
                cwd=clone,
                env=environment,
                stdin=subprocess.DEVNULL,
                stdout=file,
                stderr=subprocess.STDOUT,
                start_new_session=True,
            )
        say(f"begins: {section.name}")

    @property
    def output(self) -> str:
        """What it has printed so far."""
        return self.log.read_text(encoding="utf-8", errors="replace")

    @property
    def seconds(self) -> float:
        """Seconds since it began."""
        return time.monotonic() - self.began

    def stop(self) -> None:
        """End it with all that it has started."""
        for number in (signal.SIGTERM, signal.SIGKILL):
            with suppress(ProcessLookupError):
                os.killpg(self.process.pid, number)
            with suppress(subprocess.TimeoutExpired):
                self.process.wait(5)


def run_all(clone: Path, work: Path, sections: Sequence[Section]) -> None:
    """Run sections; end the gate at the first that fails."""
    waiting = [*sections]
    running: list[Running] = []
    seconds: dict[str, float] = {}
    summaries: dict[str, list[str]] = {}
    try:
        while waiting or running:
            for section in [one for one in waiting if seconds.keys() >= {*one.after}]:
                waiting.remove(section)
                running.append(Running(section, clone, work))
            time.sleep(0.2)
            for one in [one for one in running if one.process.poll() is not None]:
                running.remove(one)
                name = one.section.name
                print(one.output, flush=True)
                if one.process.returncode != 0:
                    end_red(one)
                say(f"passed: {name}, in {one.seconds:.0f} s")
                seconds[name] = one.seconds
                summaries[name] = [*commands_in(one.output), *tests_in(one.output)]
                summaries[name] += costs_in(one.costs)
    finally:
        for one in running:
            one.stop()
    say("all passed; seconds of each section and of its commands, CPU seconds of its tests")
    for name, spent in seconds.items():
        print(f"{spent:6.0f}  {name}")
        for line in summaries[name]:
            print(f"        {line}")


def commands_in(output: str) -> list[str]:
    """Return lines with the longest commands of a walk and their seconds."""
    found = []
    command = ""
    for text in output.splitlines():
        if text.startswith("$ "):
            command = text.removeprefix("$ ")
        elif match := re.fullmatch(r"  \((\d+) s\)", text):
            found.append((int(match[1]), command))
    longest = sorted(found, reverse=True)[:3]
    return [f"{seconds:6}  $ {command}" for seconds, command in longest if seconds > 0]


def tests_in(output: str) -> list[str]:
    """Return the line with which pytest ends, if a section runs tests."""
    return re.findall(r"^\d+ passed.*", output, re.MULTILINE)[-1:]


def costs_in(path: Path) -> list[str]:
    """Return lines with the CPU seconds of files of tests, of tests, and of compiling in them."""
    if not path.exists():
        return []
    tests = [json.loads(line) for line in path.read_text(encoding="utf-8").splitlines()]
    seconds: Counter[str] = Counter()
    files: Counter[str] = Counter()
    compiling: Counter[str] = Counter()
    times: Counter[str] = Counter()
    for test in tests:
        seconds[test["test"]] += test["seconds"]
        files[test["test"].partition("::")[0]] += test["seconds"]
        compiling.update(test["compiling"])
        times.update([*test["compiling"]])
    lines = [f"{sum(seconds.values()):6.0f}  of CPU in tests; of these {len(files)} files most in"]
    lines += [f"{spent:6.0f}    {name}" for name, spent in files.most_common(15)]
    lines += ["        in these tests"]
    lines += [f"{spent:6.0f}    {name}" for name, spent in seconds.most_common(15)]
    lines += [f"{sum(compiling.values()):6.0f}  of CPU compiling in the processes of tests"]
    lines += [
        f"{spent:6.0f}    {name}, by {times[name]} tests"
        for name, spent in compiling.most_common(8)
    ]
    return lines


RED = re.compile(r"^(E +)?(?:FAILED|ERROR) (tests/\S+?::.+?)(?: - .*)?$", re.MULTILINE)
"""A test that pytest names at its end; after an E, one of `test_plain.py`, without the compiler."""


def end_red(failed: Running) -> NoReturn:
    """Name what failed and what repeats it, in the last lines of the gate, and end it."""
    say(f"FAILED: {failed.section.name}, after {failed.seconds:.0f} s; its output stands above")
    tests = [*dict.fromkeys(RED.findall(failed.output))]
    for within, test in tests:
        print(f"gate: red: {test}\n      repeat: {PLAIN if within else PYTEST} {shlex.quote(test)}")
    if not tests:
        last = [line for line in failed.output.splitlines() if line.strip()][-3:]
        begun = re.findall(r"^\$ (.*)$", failed.output, re.MULTILINE)
        print("gate: red: " + "\n           ".join(last or ["no output"]))
        print("      repeat: " + (begun[-1] if begun else failed.section.commands.strip()))
    sys.stdout.flush()
    sys.exit(1)


def interrupted(number: int, frame: object) -> NoReturn:
    """End the gate, and by the way what it has started."""
    sys.exit(128 + number)


def main(part: str = "", *_: str) -> None:
    """Clone HEAD and run the sections of a part there, or all."""
    sections = sections_of(part)
    signal.signal(signal.SIGTERM, interrupted)
    sys.stdout.reconfigure(errors="replace")  # whatever a section prints, wherever it goes
    with tempfile.TemporaryDirectory(prefix="gate-", ignore_cleanup_errors=True) as folder:
        work = Path(folder)
        clone = work / "clone"
        git = ["git", "-c", "safe.directory=*"]
        subprocess.run([*git, "clone", "--quiet", "--no-hardlinks", CHECKOUT, clone], check=True)
        head = ["git", "log", "-1", "--format=%h %s"]
        say(subprocess.run(head, cwd=clone, check=True, capture_output=True, text=True).stdout)
        kernels = clone / "nlds_vines" / "kernels" / "__pycache__"
        kept = os.environ.get("GATE_KERNELS") if part == "kernels" else None
        if kept:
            copy_kernels(Path(kept), kernels)
        run_all(clone, work, sections)
        if kept:
            copy_kernels(kernels, Path(kept))


if __name__ == "__main__":
    main(*sys.argv[1:])
