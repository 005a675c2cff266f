"""A page (.html) of histories, suites, response curves or a tuning: one file, without scripts.

It has what was asked, the systems drawn, the report with its table, pictures and assumptions.
"""

from __future__ import annotations

import base64
import tempfile
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from html import escape
from pathlib import Path
from typing import Any, NamedTuple

from nlds_vines.archives.archive import ArchiveView, read
from nlds_vines.archives.files import toml_text
from nlds_vines.archives.provenance import RESPONSE_CURVES, RESPONSE_HISTORY, TUNING
from nlds_vines.bifurcation.response_curves import ResponseCurves
from nlds_vines.cli.command import TASKS
from nlds_vines.errors import RequestError
from nlds_vines.explore.system_drawing import drawn_system
from nlds_vines.loads.request import HistoryRequest
from nlds_vines.loads.result import LoadScan, ResponseHistories, aligned
from nlds_vines.model.system import System
from nlds_vines.tuning.result import Tuned

MOST_SYSTEMS = 8  # systems that are drawn
MOST_NUMBERS = 50  # numbers of a list that the request on the page has; samples are in the archive
_PROVENANCE = (
    ("source", "made by"), ("commit", "commit"), ("scan_hash", "hash"),
    ("python_version", "Python"), ("numba_version", "Numba"), ("numpy_version", "NumPy"),
)  # fmt: skip
_STYLE = """
:root { color-scheme: light dark; }
body { font: 15px/1.45 system-ui, sans-serif; max-width: 62rem; margin: 2rem auto; padding: 0 1rem;
  color: #15202b; background: #fff; }
h1 { font-size: 1.5rem; } h2 { font-size: 1.15rem; margin-top: 2rem;
  border-bottom: 1px solid #c8d0d8; padding-bottom: .2rem; }
table { border-collapse: collapse; margin: .6rem 0; }
th, td { padding: .2rem .8rem .2rem 0; text-align: right; border-bottom: 1px solid #e3e8ed;
  font-variant-numeric: tabular-nums; }
th:first-child, td:first-child { text-align: left; }
.wide { overflow-x: auto; } pre { overflow-x: auto; font-size: 12.5px; }
figure { margin: .6rem 0; } figcaption { font-size: 13px; } svg { max-width: 40rem; width: 100%; }
img { max-width: 100%; background: #fff; padding: 4px; }
.systems { display: grid; grid-template-columns: repeat(auto-fit, minmax(26rem, 1fr)); gap: 1rem; }
.systems svg { background: #fff; }
@media (prefers-color-scheme: dark) { body { color: #e6edf3; background: #0d1117; }
  h2 { border-color: #30363d; } th, td { border-color: #21262d; } }
@media print { details { display: none; } h2 { break-after: avoid; }
  img, svg { break-inside: avoid; } }
"""
_POLICY = (
    '<meta http-equiv="Content-Security-Policy" content="default-src \'none\'; '
    "style-src 'unsafe-inline'; img-src data:\">"
)


def sent_page(path: Path) -> str:
    """Return the page of an archive as HTML."""
    with read(path) as view:
        content = view.content
        title = view.text("title")
        about = {words: str(view.attrs[key]) for key, words in _PROVENANCE if key in view.attrs}
        shows = _pictures(view)
    task = TASKS[content]
    result = task.read(path)
    account = _ACCOUNTS[content](result)
    sections = [
        _section("What was asked", _listed(account.asked)),
        _section("Systems", _drawn(account)),
        _section("Results", _results(result, account)),
    ]
    pictures = "".join(_picture(task.picture, path, show, words) for show, words in shows)
    sections += [
        _section("Pictures", pictures),
        _section("Assumptions", _listed(_assumptions_of(account))),
        _section("Where this comes from", _provenance(path, about, result)),
    ]
    return (
        '<!doctype html>\n<html lang="en"><head><meta charset="utf-8">'
        f'<meta name="viewport" content="width=device-width">{_POLICY}'
        f"<title>{escape(title)}</title><style>{_STYLE}</style></head><body>"
        f"<h1>{escape(title)}</h1>{''.join(sections)}</body></html>\n"
    )


def _section(title: str, body: str) -> str:
    return f"<section><h2>{escape(title)}</h2>{body}</section>" if body else ""


def _listed(lines: Iterable[str]) -> str:
    return f"<ul>{''.join(f'<li>{escape(line)}</li>' for line in lines)}</ul>"


def _table(rows: Sequence[Sequence[str]]) -> str:
    head, *others = rows
    first = "".join(f'<th scope="col">{escape(cell)}</th>' for cell in head)
    body = "".join(
        f"<tr>{''.join(f'<td>{escape(cell)}</td>' for cell in row)}</tr>" for row in others
    )
    return (
        f'<div class="wide"><table><thead><tr>{first}</tr></thead><tbody>{body}</tbody></table>'
        "</div>"
    )


# ---- what was asked, and what came out -----------------------------------------------------------


class Account(NamedTuple):
    """What a page says of a result, whichever task it is of.

    Attributes:
        asked: lines that say what was asked.
        systems: the systems, and words for each.
        history: the request of histories under loads; None of responses to a harmonic force.
        table: the rows of a comparison, the heading first; none if the report has it all.
        is_one_text: whether the lines of the report stand below each other, as a table of text.
        draws: how uncertain numbers were drawn; "" if none were.
    """

    asked: list[str]
    systems: list[tuple[System, str]]
    history: HistoryRequest | None
    table: Sequence[Sequence[str]] = ()
    is_one_text: bool = False
    draws: str = ""


def _asked_of_history(history: HistoryRequest) -> Iterator[str]:
    yield f"load: {history.load.words() or 'none, a free decay'}"
    yield f"duration: {history.duration:g} s"
    yield from history.load.records_in_words(history.duration)
    if history.heights:
        heights = [f"{name} {height:g} m" for name, height in history.heights.items()]
        yield f"heights of storeys: {', '.join(heights)}"


def _account_of_histories(result: ResponseHistories | LoadScan) -> Account:
    request = result.request
    asked = list(_asked_of_history(request))
    asked += [axis.heading() for axis in request.vary]
    systems = list(zip(request.systems, request.words, strict=True))
    table = result.rows() if not request.vary else []
    return Account(asked, systems, request, table)


def _account_of_curves(result: ResponseCurves) -> Account:
    cases = result.request.cases
    axes = [axis.heading() for case in cases for axis in case.scan.axes]
    systems = [(case.scan.system, case.scan.system.in_words()) for case in cases]
    return Account(list(dict.fromkeys(axes)), systems, None)


def _account_of_tuning(result: Tuned) -> Account:
    """Return what is said of a tuning; the system is that of its best design."""
    request = result.request
    history = request.history
    asked = [] if history is None else list(_asked_of_history(history))
    asked += [f"free: {one.heading()}" for one in request.free]
    asked += [f"uncertain: {one.words()}" for one in request.uncertain]
    asked.append(f"objective: {request.objective_in_words}")
    asked.append(f"judged by the {request.judged}")
    asked += [f"over {axis.heading()}" for axis in request.over]
    system = request.system
    if result.optima:
        best = result.optima[0]
        system = system.with_(**best.places).with_(**best.parameters)
    draws = ""
    if request.draws:
        draws = (
            f"Uncertain numbers are drawn from a scrambled Sobol sequence, {request.draws} "
            f"draws in the search and {request.fresh_draws} others to judge the optimum."
        )
    systems = [(system, system.in_words())]
    return Account(asked, systems, history, is_one_text=True, draws=draws)


_ACCOUNTS: Mapping[str, Callable[[Any], Account]] = {
    RESPONSE_HISTORY: _account_of_histories,
    RESPONSE_CURVES: _account_of_curves,
    TUNING: _account_of_tuning,
}


def _results(result: Any, account: Account) -> str:
    lines = list(result.lines())[1:]
    history = account.history
    if history is not None:
        records = history.load.records_in_words(history.duration)
        lines = [line for line in lines if line not in records]
    if account.is_one_text:
        return f"<pre>{escape(chr(10).join(lines))}</pre>"
    table = ""
    if len(account.table) > 1:
        table = _table(account.table)
        of_table = set(aligned(account.table))
        lines = [line for line in lines if line not in of_table]
    return table + _listed(line.strip() for line in lines)


def _drawn(account: Account) -> str:
    shown = account.systems[:MOST_SYSTEMS]
    drawings = "".join(drawn_system(system, words) for system, words in shown)
    left = len(account.systems) - MOST_SYSTEMS
    more = f"<p>{left} more systems are not drawn.</p>" if left > 0 else ""
    return f'<div class="systems">{drawings}</div>{more}'


# ---- pictures ------------------------------------------------------------------------------------


def _pictures(view: ArchiveView) -> list[tuple[str | None, str]]:
    """Return the panels of each picture and its words; None for the usual panels."""
    names = TASKS[view.content].picture.names(view)
    shows: list[tuple[str | None, str]] = [(None, "usual picture")]
    if view.content == RESPONSE_HISTORY:
        ends = (".a", "peaks", ".stroke") if "peaks" in names else (
            "drift_ratio_max", "a_max", "a1_max", "stroke_max", "impact_count",
        )  # fmt: skip
        for end in ends:
            name = next((one for one in names if one.endswith(end)), None)
            if name is not None:
                shows.append((name, names[name]))
    return shows


def _picture(picture: Any, path: Path, show: str | None, words: str) -> str:
    """Return a picture of an archive as an image within the page; a line if it has none."""
    with tempfile.TemporaryDirectory() as folder:
        target = Path(folder) / "picture.svg"
        try:
            picture.save(path, target, show)
        except RequestError as error:
            return f"<p>{escape(words)}: {escape(str(error))}</p>"
        code = base64.b64encode(target.read_bytes()).decode("ascii")
    return f'<figure><img alt="{escape(words)}" src="data:image/svg+xml;base64,{code}"></figure>'


# ---- assumptions, and where it comes from --------------------------------------------------------


def _assumptions_of(account: Account) -> Iterator[str]:
    """Yield what the numbers of a result rest on."""
    history = account.history
    systems = [system for system, _ in account.systems]
    yield "The structure is linear; dampers and walls are as drawn."
    if history is None:
        yield "Responses are those after the transient, under a harmonic force or motion."
    else:
        if history.load.shaken:
            yield (
                "Displacements, drifts and energies are relative to the ground, accelerations are "
                "absolute. All supports move alike, in one direction."
            )
        if history.load.record or history.load.suite:
            yield (
                "Records are as read, scaled as stated, without a filter or a baseline "
                "correction; they are 0 before their first sample and after their last one."
            )
        start = "in the given state" if history.state else "at rest"
        yield f"The structure is {start} at t = 0."
    struck = [system for system in systems if system.scene.walls]
    laws = {law.name: law for system in struck for law in system.contact_laws}
    for name, law in laws.items():
        instant = (
            "an impact takes no time and has an impulse" if law.instant else "forces are finite"
        )
        yield f"Contacts obey the law {name}: {instant}."
    if history is not None and history.load.suite:
        yield (
            "Medians and 84 % quantiles are over the records, interpolated linearly; failed orbits "
            "are left out."
        )
    if account.draws:
        yield account.draws
    texts: dict[str, None] = {}
    for system in systems:
        for name, text in system.assumptions.items():
            texts[f"{name}: {text}"] = None
    yield from texts


def _provenance(path: Path, about: Mapping[str, str], result: Any) -> str:
    rows = [["archive", path.name], *([words, value] for words, value in about.items())]
    cells = "".join(
        f'<tr><th scope="row">{escape(one)}</th><td>{escape(value)}</td></tr>'
        for one, value in rows
    )
    request = escape(toml_text(_shortened(result.request.document())))
    return (
        f"<table>{cells}</table><details><summary>The request (TOML); lists of more than "
        f"{MOST_NUMBERS} numbers are in the archive alone</summary><pre>{request}</pre></details>"
    )


def _shortened(value: Any) -> Any:
    """Return a document in which a long list of numbers is replaced by its length."""
    if isinstance(value, Mapping):
        return {key: _shortened(one) for key, one in value.items()}
    if isinstance(value, list | tuple):
        if len(value) > MOST_NUMBERS and not isinstance(value[0], Mapping):
            return f"{len(value)} numbers, in the archive"
        return [_shortened(one) for one in value]
    return value
