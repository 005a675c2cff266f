"""Formulas as MathML, which browsers draw by themselves: a page needs no script and no network."""

from __future__ import annotations

from typing import Any

from docutils import nodes
from docutils.utils.math.latex2mathml import tex2mathml


def _mathml(text: str, as_block: bool = False) -> str:
    """Return a formula as MathML, its primes as primes and not as apostrophes."""
    formula = tex2mathml(text.strip(), as_block=as_block)
    return formula.replace(">''<", ">″<").replace(">'<", ">′<")


def _inline(writer: Any, node: nodes.math) -> None:
    """Write a formula in a line of text."""
    writer.body.append(_mathml(node.astext()))
    raise nodes.SkipNode


def _block(writer: Any, node: nodes.math_block) -> None:
    """Write a formula on lines of its own."""
    formula = _mathml(node.astext(), as_block=True)
    writer.body.append(f'<div class="formula">{formula}</div>')
    raise nodes.SkipNode


def setup(app: Any) -> dict[str, bool]:
    """Register the way in which formulas are written; `conf.py` chooses it."""
    app.add_html_math_renderer(
        "mathml", inline_renderers=(_inline, None), block_renderers=(_block, None)
    )
    return {"parallel_read_safe": True, "parallel_write_safe": True}
