"""Commands as users give them: in this process, or in one of their own."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

REPO = Path(__file__).resolve().parents[1]


def started(*words, cwd=None, **environment):
    """Start Python with these words, which finds the package; return the process."""
    return subprocess.Popen(
        [sys.executable, *map(str, words)], cwd=cwd, text=True, stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE, stderr=subprocess.PIPE,
        env={**os.environ, "PYTHONPATH": str(REPO), **environment},
    )  # fmt: skip


def python(*words, **where):
    """Run Python with these words, which finds the package; return what it did, with its texts."""
    with started(*words, **where) as process:
        return subprocess.CompletedProcess(words, *ended(process))


def ended(process):
    """Wait for a process; return its exit status, what it printed, and its errors."""
    out, err = process.communicate()
    return process.returncode, out, err


def printed(*words, **where):
    """Return the output of a program, which must end with status 0."""
    done = python(*words, **where)
    assert done.returncode == 0, done.stderr
    return done.stdout


def changed(folder, change):
    """Copy the package into a folder and apply `tests/changes/CHANGE.diff` there."""
    ignored = shutil.ignore_patterns("__pycache__", "_build", "_gallery")
    for name in ("nlds_vines", "data", "scans", "docs"):
        shutil.copytree(REPO / name, folder / name, ignore=ignored)
    diff = REPO / "tests" / "changes" / f"{change}.diff"
    subprocess.run(["git", "apply", "--unsafe-paths", diff], cwd=folder, check=True)
    return folder


def contents(folder):
    """Return the names of all that is in a folder, with the bytes of regular files."""
    return {
        str(path.relative_to(folder)): path.read_bytes() if path.is_file() else None
        for path in folder.rglob("*")
    }
