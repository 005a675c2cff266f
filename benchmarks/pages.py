"""Tables that a command writes into a page: between `<!-- COMMAND -->` and `<!-- end -->`."""

from __future__ import annotations

import re
from collections.abc import Iterable
from pathlib import Path


def fill(page: Path, command: str, lines: Iterable[str]) -> None:
    """Replace the lines between the marks of a command in a page.

    Raises `ValueError` unless the page has the marks once.
    """
    begin, end = f"<!-- {command} -->\n", "<!-- end -->"
    text = page.read_text(encoding="utf-8")
    if text.count(begin) != 1:
        raise ValueError(f"{page} must have the line {begin.strip()!r} once")
    pattern = re.compile(re.escape(begin) + r".*?" + re.escape(end), re.DOTALL)
    body = "".join(f"{line}\n" for line in lines)
    page.write_text(pattern.sub(lambda _: f"{begin}\n{body}\n{end}", text), encoding="utf-8")
