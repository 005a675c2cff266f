"""The options that override a request file: declared, and read, as its settings say."""

from __future__ import annotations

import argparse
import re
from collections.abc import Collection, Mapping
from dataclasses import replace
from types import MappingProxyType
from typing import Any

from nlds_vines.cli.option_values import comma_separated, number_or_word
from nlds_vines.cli.parser import Parser
from nlds_vines.model.setting import Checked, Real, Setting, Truth, Whole, settings_of

_LINK = re.compile(r"\[([^]]*)\]\([^)]*\)|`")
"""A link in Markdown, of which its words are kept, and the marks of code."""


def add_settings(
    group: Parser | argparse._ArgumentGroup,
    *owners: Any,
    but: Collection[str] = (),
    usual: Mapping[str, Any] = MappingProxyType({}),
) -> None:
    """Declare the options of requests and of their tables, in the order of the fields.

    Arguments: `but`, the keys that the command has no option for, or one of its own; `usual`, its
    own defaults by key.
    """
    for owner in owners:
        for said in settings_of(owner).values():
            if said.has_option and said.key not in but:
                told = replace(said, default=usual.get(said.key, said.default))
                group.add_argument(said.flag, dest=_name(said), help=_help(told), **_how(said))


def _how(said: Setting) -> dict[str, Any]:
    """Return how argparse is to read an option."""
    if isinstance(said.check, Truth):
        return {"action": "store_true", "default": None}
    kinds = {Whole: int, Real: float}
    kind = kinds.get(type(said.check))
    return {"metavar": said.form} | ({"type": kind} if kind else {})


def _help(said: Setting) -> str:
    default = f" [{said.default_in_words}]" if said.default_in_words else ""
    return _LINK.sub(lambda found: found[1] or "", said.words + default).replace("%", "%%")


def _name(said: Setting) -> str:
    return f"{said.table}.{said.key}"


def changed(options: argparse.Namespace, *owners: Any) -> dict[str, dict[str, Any]]:
    """Return the tables that the options change in a request file, as a document of one.

    Raises `RequestError`, which names the option, for a text that cannot be read.
    """
    found: dict[str, dict[str, Any]] = {}
    for owner in owners:
        for said in settings_of(owner).values():
            value = getattr(options, _name(said), None)
            if value is not None:
                found.setdefault(said.table, {})[said.key] = _read(said, value)
    return found


def _read(said: Setting, value: Any) -> Any:
    """Return what the value of an option means in a file."""
    if not isinstance(said.check, Checked):
        return value
    return comma_separated(value) if said.check.listed else number_or_word(said.flag, value)
