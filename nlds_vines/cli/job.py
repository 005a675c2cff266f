"""The same as `cli.command`."""

from __future__ import annotations

import argparse
import os
from pathlib import Path
from typing import Any

from nlds_vines.cli.command import Job as Job
from nlds_vines.cli.options import Parser
from nlds_vines.cli.paths import optional_path, request_path
from nlds_vines.cli.run_options import run_options


def add_files(parser: Parser, source: str, words: str, archive: str) -> None:
    """Declare what a task reads, the `source`, in `words`, and what it writes: -o and --plot."""
    parser.add_argument("source", nargs="?", metavar=source, help=words)
    parser.add_argument("-o", "--output", metavar="FILE.h5", help=f"archive [{archive}]")
    parser.add_argument("--plot", metavar="FILE", help="picture: .png, .pdf or .svg")


def files_of(options: argparse.Namespace, usual: str) -> dict[str, Any]:
    """Return the files that options name, and how they say that it runs, for a `Job`.

    Arguments: `usual`, the name of the archive where none is given.
    """
    return {
        "source": request_path(options.source),
        "archive": Path(usual if options.output is None else options.output),
        "plot": optional_path(options.plot),
        "how": run_options(options),
    }


def named_after(source: str | os.PathLike[str] | None, usual: str) -> str:
    """Return the name of an archive: that of what is read with `.h5` in this folder, or `usual`."""
    return usual if source is None else f"{Path(source).stem}.h5"
