"""What the program costs beside an earlier state of it, on this machine, now.

    python -m benchmarks.speed set6 host-3                    CPU times of some cases
    python -m benchmarks.speed --against 730e54b4 set6        ... and their ratios to a commit's
    python -m benchmarks.speed --kernels set6                 ... and how much of it kernels do
    python -m benchmarks.speed --list                         the cases

Without names all cases are timed, which takes an hour. `cases.py` has them. The commit is checked
out into a folder for temporary files and stays there with its compiled kernels, so that a second
comparison begins at once; a folder of the project may be given instead. Each version runs in a
process of its own, and the two take turns. The result is the median ratio of their CPU times, with
the quartiles in brackets. The ratio of the shortest times follows; it depends least on other work
on the machine.

The case `cold` starts commands with an empty cache of compiled kernels, three times at most.
"""

from __future__ import annotations

import argparse
import getpass
import io
import json
import os
import subprocess
import sys
import tarfile
import tempfile
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from statistics import median, quantiles
from typing import NamedTuple

from benchmarks import cold
from benchmarks.cases import GROUPS

HERE = Path(__file__).resolve().parents[1]
ROUNDS = 15  # pairs of times
COLD = "cold"
COLD_ROUNDS = 3  # each takes minutes
COLD_GROUP = "an empty cache"


class Times(NamedTuple):
    """CPU times [s] of a piece of work: as a whole, and of its calls of compiled kernels."""

    whole: float
    kernels: float


Spends = Callable[[str], dict[str, Times]]
"""Does a piece of work once; returns the times of each row of the table that it fills."""


# ---- an earlier state ----------------------------------------------------------------------------


def git(*words: str) -> bytes:
    """Return the output of git; raise SystemExit with its message if it fails."""
    done = subprocess.run(["git", "-C", str(HERE), *words], capture_output=True)
    if done.returncode:
        raise SystemExit(done.stderr.decode().strip())
    return done.stdout


def checkout_of(commit: str) -> Path:
    """Return a folder with the files of a commit, unpacked where temporary files are."""
    name = git("rev-parse", "--verify", f"{commit}^{{commit}}").decode().strip()
    home = Path(tempfile.gettempdir()) / f"nlds_vines-{getpass.getuser()}"
    home.mkdir(mode=0o700, exist_ok=True)
    folder = home / name[:12]
    if not folder.exists():
        with tempfile.TemporaryDirectory(dir=home) as unpacked:
            with tarfile.open(fileobj=io.BytesIO(git("archive", name))) as archive:
                archive.extractall(unpacked, filter="data")
            Path(unpacked).rename(folder)
            Path(unpacked).mkdir()  # which the block removes
    return folder


def folder_of(state: str) -> Path:
    """Return the folder of a commit, or that of a path to a checkout."""
    if (Path(state) / "nlds_vines").is_dir():
        return Path(state).resolve()
    return checkout_of(state)


# ---- times ---------------------------------------------------------------------------------------


@contextmanager
def process_of(folder: Path) -> Iterator[Spends]:
    """Start a process with the package of a folder; yield a function that does work there."""
    with subprocess.Popen(
        [sys.executable, "-P", str(HERE / "benchmarks" / "cases.py")],
        text=True,
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        env={**os.environ, "PYTHONPATH": str(folder)},
    ) as process:
        assert process.stdin is not None
        assert process.stdout is not None
        source = process.stdout.readline().strip()
        if source != str(folder):
            raise SystemExit(f"{folder}: Python loads the package of {source or 'no folder'}")

        def spends(name: str) -> dict[str, Times]:
            print(name, file=process.stdin, flush=True)
            answer = process.stdout.readline()  # type: ignore[union-attr]
            if not answer:
                raise SystemExit(f"{folder}: {name} failed")
            whole, kernels, note = json.loads(answer)
            if note:
                print(f"{folder}: {name}: {note}", file=sys.stderr)
            return {name: Times(whole, kernels)}

        try:
            yield spends
        finally:
            process.kill()


def cold_of(folder: Path) -> Spends:
    """Return a function that runs commands from an empty cache, and returns a row for each."""

    def spends(name: str) -> dict[str, Times]:
        costs = cold.costs(folder)
        return {f"{name}, {command}": Times(cost.cpu, 0.0) for command, cost in costs.items()}

    return spends


def in_turn(
    ours: Spends, other: Spends | None, name: str, rounds: int
) -> dict[str, tuple[list[Times], list[Times]]]:
    """Return the times of each row here and in the other state, round by round.

    Each is the first of a pair by turns.
    """
    rows: dict[str, tuple[list[Times], list[Times]]] = {}
    for number in range(rounds):
        pair = [(0, ours)]
        if other is not None:
            pair.append((1, other))
        if number % 2:
            pair.reverse()
        for side, spends in pair:
            for row, times in spends(name).items():
                rows.setdefault(row, ([], []))[side].append(times)
    return rows


# ---- the table -----------------------------------------------------------------------------------


def ratio_text(ours: list[float], others: list[float]) -> str:
    """Return the median of the ratios of pairs, their quartiles, and the ratio of the least."""
    ratios = [a / b for a, b in zip(ours, others, strict=True)]
    low, high = min(ratios), max(ratios)
    if len(ratios) > 3:
        low, _, high = quantiles(ratios, n=4)
    least = min(ours) / min(others)
    return f"{median(ratios):6.3f} ({low:.3f} to {high:.3f}), of the shortest {least:.3f}"


def row_text(name: str, ours: list[Times], others: list[Times], with_kernels: bool) -> str:
    """Return a row: the time here, its ratio to the other, and the same of kernels."""
    whole = [times.whole for times in ours]
    kernels = [times.kernels for times in ours]
    text = f"{name:32}{median(whole):10.4f} s"
    if others:
        text += f"  {ratio_text(whole, [times.whole for times in others])}"
    if with_kernels and median(kernels):
        share = median(a / b for a, b in zip(kernels, whole, strict=True))
        text += f"   kernels {100 * share:.0f} %"
        if others:
            text += f" {ratio_text(kernels, [times.kernels for times in others])}"
    return text


def main(words: list[str] | None = None) -> None:
    table = {name: group for group, of in GROUPS.items() for name in of}
    table[COLD] = COLD_GROUP
    parser = argparse.ArgumentParser(description="CPU times, beside those of another state.")
    parser.add_argument("cases", nargs="*", metavar="CASE", help="names of --list; by default all")
    parser.add_argument("--list", action="store_true", help="print the cases")
    parser.add_argument(
        "--against", metavar="COMMIT", help="a commit of this project, or a folder with one"
    )
    parser.add_argument("--rounds", type=int, default=ROUNDS, metavar="N", help=f"({ROUNDS})")
    parser.add_argument("--kernels", action="store_true", help="and how much of it kernels do")
    options = parser.parse_args(words)
    unknown = [name for name in options.cases if name not in table]
    if unknown:
        parser.error(f"no case {', '.join(unknown)}; allowed: {', '.join(table)}")
    if options.rounds < 1:
        parser.error(f"--rounds {options.rounds}; allowed: 1 and more")
    chosen = options.cases or list(table)
    if options.list:
        for line in grouped(table, chosen, lambda name: [f"    {name}"]):
            print(line)
        return
    folder = None if options.against is None else folder_of(options.against)
    with ExitStack() as stack:
        ours = stack.enter_context(process_of(HERE))
        other = None if folder is None else stack.enter_context(process_of(folder))

        def rows_of(name: str) -> Iterator[str]:
            if name == COLD:
                rounds = min(options.rounds, COLD_ROUNDS)
                cold_there = None if folder is None else cold_of(folder)
                rows = in_turn(cold_of(HERE), cold_there, name, rounds)
            else:
                rows = in_turn(ours, other, name, options.rounds)
            for row, (mine, theirs) in rows.items():
                yield row_text(row, mine, theirs, options.kernels)

        for line in grouped(table, chosen, rows_of):
            print(line, flush=True)


def grouped(
    table: dict[str, str], chosen: list[str], rows_of: Callable[[str], Iterator[str] | list[str]]
) -> Iterator[str]:
    """Yield the rows of the chosen cases, each group under its name."""
    group = ""
    for name in chosen:
        if table[name] != group:
            group = table[name]
            yield f"{group}:"
        yield from rows_of(name)


if __name__ == "__main__":
    main()
