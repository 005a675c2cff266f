#!/usr/bin/env python3
"""Does what pages tell a reader to do, word for word and in order, in the current folder.

    .ci/walk.py README.md docs/tutorial.md
    .ci/walk.py README.md:1-2

The second line takes two steps of a page alone, counted from 1.  Commands stand in ```sh blocks,
and run in one shell for each page.  Python (```python) runs as a program of its own, and must print
what the ```text block after it shows.  Each line of a ```console block must occur in what the
commands above it have printed.  A ```toml block after "Save this as `NAME`" becomes that file.
Anything that fails, and a command that changes a file which an earlier one has written, ends the
walk with status 1.  It needs nothing but Python.
"""

from __future__ import annotations

import os
import re
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from itertools import zip_longest
from pathlib import Path

BLOCK = re.compile(r"^```(\w+)\n(.*?)^```$", re.MULTILINE | re.DOTALL)
SAVED = re.compile(r"Save this as `([\w.]+)`:\s*$")
OURS = ("NUMBA_CACHE_DIR", "NUMBA_NUM_THREADS", "PYTHONPATH", "PYTHONHOME", "VIRTUAL_ENV")


def steps(text: str) -> Iterator[tuple[str, str, str]]:
    """Yield what a page tells to do: (sh, line, ""), (python, program, shown), (file, name, text).

    Lines of a ```console block are (shown, line, "").
    """
    blocks = list(BLOCK.finditer(text))
    for block, after in zip_longest(blocks, blocks[1:]):
        language, body = block.groups()
        if language == "sh":
            yield from (("sh", line, "") for line in body.splitlines() if line.strip())
        elif language == "python":
            is_shown = after is not None and after[1] == "text"
            yield "python", body, after[2] if is_shown else ""
        elif language == "toml" and (name := SAVED.search(text[: block.start()])):
            yield "file", name[1], body
        elif language == "console":
            yield from (("shown", line, "") for line in body.splitlines())


class Shell:
    """A shell that stays, so that an environment which one command activates holds for the next."""

    def __init__(self) -> None:
        """Start it, without what a developer's shell has set."""
        clean = {name: value for name, value in os.environ.items() if name not in OURS}
        self.process = subprocess.Popen(
            ["bash", "-uo", "pipefail"],
            env=clean,
            text=True,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
        )

    def run(self, line: str) -> tuple[int, str]:
        """Run a line; return its exit status and what it printed, which is shown meanwhile."""
        end = f"-- end of a step {os.getpid()} --"
        self.process.stdin.write(f'{{ {line}\n}} </dev/null\nprintf "\\n%s %d\\n" "{end}" "$?"\n')
        self.process.stdin.flush()
        printed = []
        for text in self.process.stdout:
            if text.startswith(end):
                return int(text.removeprefix(end)), "".join(printed)
            printed.append(text)
            sys.stdout.write(text)
            sys.stdout.flush()
        return 1, "".join(printed)  # the shell has ended


def written() -> dict[str, int]:
    """Return when each file in this folder, not below it, was last changed [ns]."""
    return {entry.name: entry.stat().st_mtime_ns for entry in os.scandir() if entry.is_file()}


def fail(text: str) -> None:
    """End the walk."""
    print(f"walk: {text}", file=sys.stderr)
    sys.exit(1)


def run_python(shell: Shell, program: str, shown: str) -> str:
    """Run a program in the shell's environment; it must print what is shown."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "program.py")
        path.write_text(program, encoding="utf-8")
        status, printed = shell.run(f"python {path}")
    if status != 0 or (shown and shown.strip() not in printed):
        fail(f"the program\n{program}ended with status {status}; it should print\n{shown}")
    return printed


def walk(page: Path, chosen: slice) -> None:
    """Take the chosen steps of a page."""
    shell, printed = Shell(), ""
    taken = [*steps(page.read_text(encoding="utf-8"))][chosen]
    if not taken:
        fail(f"{page} has no such step")
    for kind, what, more in taken:
        before, begin = written(), time.monotonic()
        if kind == "shown":
            if what not in printed:
                fail(f"{page} shows a line that was not printed: {what!r}")
            continue
        if kind == "file":
            Path(what).write_text(more, encoding="utf-8")
            continue
        print(f"$ {what}" if kind == "sh" else "$ python <<<...", flush=True)
        if kind == "python":
            printed += run_python(shell, what, more)
        else:
            status, text = shell.run(what)
            printed += text
            if status != 0:
                fail(f"{page}: status {status} of: {what}")
        after = written()
        if changed := [name for name in before if after.get(name) != before[name]]:
            fail(f"{page}: {what!r} changed {', '.join(changed)}, which an earlier one had written")
        print(f"  ({time.monotonic() - begin:.0f} s)", flush=True)


def chosen_steps(span: str) -> slice:
    """Return the steps that `3` or `1-2` names; all for an empty text."""
    if not span:
        return slice(None)
    first, _, last = span.partition("-")
    return slice(int(first) - 1, int(last or first))


if __name__ == "__main__":
    for argument in sys.argv[1:]:
        print(f"-- {argument}", flush=True)
        name, _, span = argument.partition(":")
        walk(Path(name), chosen_steps(span))
