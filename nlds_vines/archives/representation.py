"""The representation of results: a few lines in Python, a table in a notebook."""

from __future__ import annotations

import dataclasses
import html
import textwrap
from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np

MOST_LINES, WIDTH = 5, 100  # lines of a repr, and characters of a line
Rows = Iterable[tuple[str, str]]  # names with their values, both as text


class Outlined:
    """A result whose repr has at most five lines; dataclasses of it are declared `repr=False`.

    The repr begins with `class_name`, by default the name of the class.
    """

    class_name = ""

    def heading(self) -> str:
        """Return the text after the class name: by default the title, if it has one."""
        return str(getattr(self, "title", ""))

    def outline(self) -> Rows:
        """Return names and values for the lines below the heading: by default its fields."""
        values = {field.name: getattr(self, field.name) for field in dataclasses.fields(self)}  # type: ignore[arg-type]
        for name, value in values.items():
            if value is not None and name != "title" and (words := in_words(value)):
                yield name, words

    def _head(self) -> str:
        name = self.class_name or type(self).__name__
        heading = self.heading()
        return f"{name}: {heading}" if heading else name

    def __repr__(self) -> str:
        lines = [_cut(self._head(), WIDTH)]
        rows = list(self.outline())
        if len(rows) >= MOST_LINES:  # too many for a line each: join them
            rows = [("", "; ".join(f"{name} {words}".strip() for name, words in rows))]
        for name, words in rows:
            text = f"{name}: {words}" if name else words
            lines += textwrap.wrap(text, WIDTH, initial_indent="  ", subsequent_indent="    ")
        if len(lines) > MOST_LINES:
            lines[MOST_LINES - 1 :] = [_cut(lines[MOST_LINES - 1], WIDTH - 4) + " ..."]
        return "\n".join(lines)

    def _repr_html_(self) -> str:
        head = html.escape(self._head())
        left = 'style="text-align:left"'
        rows = "".join(
            f"<tr><th {left}>{html.escape(name)}</th><td {left}>{html.escape(words)}</td></tr>"
            for name, words in self.outline()
        )
        return f"<table><caption><b>{head}</b></caption>{rows}</table>"


def _cut(text: str, width: int) -> str:
    text = " ".join(text.split("\n"))
    return text if len(text) <= width else f"{text[: width - 4]} ..."


def numbers(values: Mapping[str, Any]) -> str:
    return ", ".join(f"{name} = {value:.6g}" for name, value in values.items())


def in_words(value: object) -> str:
    """Return a few words: the shape of an array of over 4 values, the heading of an `Outlined`."""
    if isinstance(value, Outlined):
        return value.heading() or type(value).__name__
    if isinstance(value, np.ndarray):
        return f"array {value.shape}" if value.size > 4 else _cut(str(value.tolist()), WIDTH)
    if isinstance(value, float):
        return f"{value:.6g}"
    if isinstance(value, Mapping):
        is_numeric = all(isinstance(item, float) for item in value.values())
        return numbers(value) if is_numeric else ", ".join(map(str, value))
    if isinstance(value, tuple | list):
        return _cut(", ".join(in_words(item) for item in value), WIDTH)
    return _cut(str(value), WIDTH)
