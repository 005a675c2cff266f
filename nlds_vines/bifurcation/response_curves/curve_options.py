"""The options of response curves: how they are declared, and the page that they mean."""

from __future__ import annotations

import argparse
import os
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from nlds_vines.archives.toml import read_toml
from nlds_vines.bifurcation.request import Scan
from nlds_vines.bifurcation.response_curves.request import (
    ALONE_COLOUR,
    CURVE_STARTS,
    CurvePage,
    turns,
    with_structure_alone,
)
from nlds_vines.bifurcation.response_curves.request_file import load_page
from nlds_vines.cli.option_values import (
    assignments,
    settings_of,
    spaced,
)
from nlds_vines.cli.parser import Parser
from nlds_vines.cli.setting_options import add_settings, changed
from nlds_vines.errors import RequestError, at, choice, shown
from nlds_vines.model.catalogue import load_system
from nlds_vines.model.parameters import PARAMETERS
from nlds_vines.model.system import System
from nlds_vines.model.words import range_in_words, setting_in_words, system_in_words

USUAL = ("ssul-set6", "ssbl", "tmd")
"""The dampers that are compared unless others are named: those of the paper's Table 2."""

SAMPLING = {"transient": 600, "periods": 240}
"""Forcing periods discarded and sampled: long, for the sake of irregular regimes."""

_VARY = {"omega": {"start": 4.5, "stop": 8.0, "num": 351}}

Source = str | os.PathLike[str] | System | Sequence[Any] | Mapping[str, Any] | CurvePage | None
"""What may stand for a page: systems or their names, a file, the document in one."""


def add_curve_options(parser: Parser) -> None:
    """Declare the options that say what is computed."""
    group = parser.add_argument_group("options that override the request file")
    group.add_argument(
        "--system", action="append", default=[], metavar="NAME", dest="systems",
        help="a damper: of the catalogue, or a TOML file; once for each curve",
    )  # fmt: skip
    group.add_argument(
        "--set", action="append", default=[], metavar="NAME=VALUE", help="of all curves, SI units"
    )
    group.add_argument("--vary", metavar="NAME=START:STOP:NUM", help="[omega=4.5:8:351]")
    group.add_argument("--start", metavar="POLICY", help="rest, up, down or both [rest]")
    add_settings(group, Scan, CurvePage, but=("want", "effort", "signals"), usual=SAMPLING)


def changes(options: argparse.Namespace) -> dict[str, Any]:
    """Return what the options change in a request file, as a document of the same form."""
    if options.start is not None:
        choice("--start", options.start, CURVE_STARTS)
    pairs = assignments("--vary", [options.vary] if options.vary else [], "NAME=START:STOP:NUM")
    found: dict[str, Any] = {
        "set": settings_of(options),
        "vary": {name: spaced(f"--vary {name}", text) for name, text in pairs.items()},
        "start": {} if options.start is None else {"policy": options.start},
        **changed(options, Scan, CurvePage),
    }
    return {key: value for key, value in found.items() if value}


def page_from(
    source: Source, systems: Sequence[str | System], above: Mapping[str, Any], where: str
) -> CurvePage:
    """Return the page of a source with the structure alone in each panel, checked throughout.

    Arguments: the `source`; `systems` that replace its curves; `above`, a document of changes, and
    `where` they come from, for messages.

    Raises `RequestError`, one line that names place, key, value and what is allowed.
    """
    if isinstance(source, CurvePage) and not (systems or above):
        return source
    if isinstance(source, CurvePage) or _is_document(source):
        document: Any = source.document() if isinstance(source, CurvePage) else source
        if systems:
            above = {**above, "curves": _curves(systems), "panels": [{}]}
        page = load_page(document, above, where)
    else:
        chosen = systems or _as_systems(source)
        page = load_page(_document(chosen), above, where)
        if "title" not in above:
            page = replace(page, title=_made_up_title(page, above.get("set", {})))
    return with_structure_alone(page)


def _is_document(source: Source) -> bool:
    """Tell whether a source is a page, in a file or as nested tables, and not a system."""
    if isinstance(source, Mapping):
        return True
    if not isinstance(source, str | os.PathLike) or not str(source).endswith(".toml"):
        return False
    return "curves" in read_toml(Path(source))


def _as_systems(source: Source) -> Sequence[str | System]:
    """Return the systems that a source names; the usual ones for None."""
    if source is None:
        return USUAL
    if isinstance(source, str | os.PathLike | System):
        return [source if isinstance(source, System) else str(source)]
    if isinstance(source, Sequence):
        return list(source)
    raise RequestError(f"{shown(source)} is no system, no list of systems and no page of curves")


def _document(systems: Sequence[str | System]) -> dict[str, Any]:
    """Return the request file of a page that nobody wrote."""
    return {
        "vary": _VARY,
        "sampling": SAMPLING,
        "record": {"want": ["impacts", "energy"]},
        "figure": {"reduction": True},
        "curves": _curves(systems),
    }


def _curves(systems: Sequence[str | System]) -> list[dict[str, Any]]:
    """Return the tables [[curves]] of systems, each with a colour and a line of its own."""
    found = []
    for number, name in enumerate(systems):
        with at("--system"):
            system = name if isinstance(name, System) else load_system(name)
        colour, line = turns(number) if system.scene.damper else (ALONE_COLOUR, "solid")
        found.append(
            {
                "system": system,
                "label": system_in_words(system),
                "colour": colour,
                "line": line,
            }
        )
    return found


def _made_up_title(page: CurvePage, settings: Mapping[str, Any]) -> str:
    """Return a title made of what is set and of what varies."""
    words = [setting_in_words(*item) for item in settings.items() if item[0] in PARAMETERS]
    return ", ".join(["Response curves", *words, range_in_words(page.axis, page.values)])
