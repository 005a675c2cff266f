"""Pages that a benchmark writes: the option `--markdown`, and the command at the end of each."""

from __future__ import annotations

import os
import shlex
from collections.abc import Callable
from pathlib import Path
from typing import Any

from nlds_vines.accuracy.command import Job
from nlds_vines.archives.durable import write_text
from nlds_vines.cli.parser import Parser
from nlds_vines.cli.paths import check_output, check_writable, refuse_replacing


def declare_page(parser: Parser) -> None:
    """Declare the option that names a page."""
    parser.add_argument("--markdown", metavar="FILE.md", help="write the page, too")


def command_line(name: str, argv: list[str]) -> str:
    """Return the command `name` with arguments, without those that only say how it ran."""
    given = [text for text in argv if text not in ("--resume", "--overwrite", "--quiet")]
    return shlex.join([*name.split(), *given])


def page_writer(options: Any, job: Job, command: str) -> Callable[[Callable[..., str]], list[str]]:
    """Return what makes a page of (picture, command), writes it if asked to, and splits it.

    Raises `RequestError` where it cannot be written, or a file is there that is not its own.
    """
    path = None if options.markdown is None else Path(options.markdown)
    if path is not None:
        check_writable("--markdown", path)
        check_output(job.archive, job.source, job.plot, path)
        refuse_replacing("page", path, job.how, command)

    def written(page: Callable[[str, str], str]) -> list[str]:
        where = os.path.relpath(job.plot, path.parent if path else Path())
        text = page(where, command)
        if path is not None:
            write_text(path, text)
        return text.splitlines()

    return written
