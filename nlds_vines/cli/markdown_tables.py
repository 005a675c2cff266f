"""Tables in Markdown, as every page and command prints them."""

from __future__ import annotations

from collections.abc import Container, Iterable, Iterator, Sequence


def table(
    head: Sequence[str],
    rows: Iterable[Sequence[str]],
    right: Container[int] = (),
    padded: bool = False,
) -> Iterator[str]:
    """Yield the lines of a Markdown table, each row as soon as it is there.

    Arguments: the cells of its `head`; its `rows`, where cells missing at the end are empty; the
    columns, counted from 0, that are aligned to the `right`; `padded` makes all cells of a column
    equally wide, for a terminal, and needs all rows before the first line.
    """
    whole: Iterable[Sequence[str]] = ([*row, *[""] * (len(head) - len(row))] for row in rows)
    if padded:
        head, *whole = _padded([head, *whole], right)
    widths = [len(text) + 2 if padded else 4 if i in right else 3 for i, text in enumerate(head)]
    rules = ("-" * (w - 1) + (":" if i in right else "-") for i, w in enumerate(widths))
    yield _line(head)
    yield f"|{'|'.join(rules)}|"
    yield from map(_line, whole)


def _padded(rows: Sequence[Sequence[str]], right: Container[int]) -> Iterator[list[str]]:
    """Yield rows with blanks added to each cell, up to the width of its column."""
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    for row in rows:
        sized = enumerate(zip(row, widths, strict=True))
        yield [text.rjust(w) if i in right else text.ljust(w) for i, (text, w) in sized]


def _line(cells: Iterable[str]) -> str:
    """Return a row; a bar within a cell would end it, and becomes a slash."""
    return f"| {' | '.join(cell.replace('|', '/') for cell in cells)} |"
