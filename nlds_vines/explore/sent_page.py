"""A page (.html) of an archive that holds no map: one file, without scripts.

It has what was asked, the systems drawn, the report with its table, pictures and assumptions.
"""

from __future__ import annotations

import base64
import re
import tempfile
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from html import escape
from pathlib import Path
from typing import Any, NamedTuple

import nlds_vines as nv
from nlds_vines.explore.system_drawing import drawn_system

AFTER_TRANSIENT = "Responses are those after the transient, under a harmonic force or motion."
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
    with nv.read(path) as view:
        title = view.text("title")
        about = {words: str(view.attrs[key]) for key, words in _PROVENANCE if key in view.attrs}
    result = nv.open_archive(path)
    account = account_of(result)
    sections = [
        _section("What was asked", _listed(account.asked)),
        _section("Systems", _drawn(account)),
        _section("Results", _results(result, account)),
    ]
    shows = _pictures(path, isinstance(result, _HISTORIES))
    pictures = "".join(_picture(path, show, words) for show, words in shows)
    sections += [
        _section("Pictures", pictures),
        _section("Assumptions", _listed(assumptions_of(account))),
        _section("Where this comes from", _provenance(path, about, account)),
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
    entries = "".join(f"<li>{escape(line)}</li>" for line in lines)
    return f"<ul>{entries}</ul>" if entries else ""


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
        request: the request that gives the same numbers.
        history: the request of histories under loads; None of responses to a harmonic force.
        assumed: what the numbers rest on, beside what follows from the systems and from a load.
        table: the rows of a comparison, the heading first; none if the report has it all.
        is_one_text: whether the lines of the report stand below each other, as a table of text.
        draws: how uncertain numbers were drawn; "" if none were.
    """

    asked: list[str]
    systems: list[tuple[nv.System, str]]
    request: Any
    history: nv.HistoryRequest | None = None
    assumed: str = ""
    table: Sequence[Sequence[str]] = ()
    is_one_text: bool = False
    draws: str = ""


def _asked_of_history(history: nv.HistoryRequest) -> Iterator[str]:
    yield f"load: {history.load.words() or 'none, a free decay'}"
    yield f"duration: {history.duration:g} s"
    yield from history.load.records_in_words(history.duration)
    if history.heights:
        heights = [f"{name} {height:g} m" for name, height in history.heights.items()]
        yield f"heights of storeys: {', '.join(heights)}"


def _account_of_histories(result: nv.ResponseHistories | nv.LoadScan) -> Account:
    request = result.request
    asked = list(_asked_of_history(request))
    asked += [axis.heading() for axis in request.vary]
    systems = list(zip(request.systems, request.words, strict=True))
    table = result.rows() if not request.vary else []
    return Account(asked, systems, request, history=request, table=table)


def _account_of_curves(result: nv.ResponseCurves) -> Account:
    cases = result.request.cases
    axes = [axis.heading() for case in cases for axis in case.scan.axes]
    systems = [(case.scan.system, case.scan.system.in_words()) for case in cases]
    return Account(list(dict.fromkeys(axes)), systems, result.request, assumed=AFTER_TRANSIENT)


def _account_of_tuning(result: nv.Tuned) -> Account:
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
    assumed = AFTER_TRANSIENT if history is None else ""
    return Account(
        asked, systems, request, history, assumed, is_one_text=True, draws=draws,
    )  # fmt: skip


def _account_of_branches(result: nv.Continued) -> Account:
    request = result.request
    asked = [f"along {one.heading()}" for one in request.free]
    systems = [(request.system, request.system.in_words())]
    assumed = (
        "Branches are periodic orbits under a harmonic force or motion; an orbit between two "
        "points of a branch is not computed."
    )
    table = special_points(result, lambda name: (name, 1.0))
    return Account(asked, systems, request, assumed=assumed, table=table)


def _account_of_portrait(result: nv.Portrait) -> Account:
    request = result.drawn_from
    asked, systems = list[str](), dict[str, nv.System]()
    for column in request.columns:
        window, words = column.window, column.system.in_words()
        asked.append(f"{words}: forcing periods {window.begin} to {window.end}")
        systems[words] = column.system
    drawn = [(system, words) for words, system in systems.items()]
    return Account(asked, drawn, request, is_one_text=True)


def _account_of_starts(result: nv.Ensemble) -> Account:
    scan = result.request
    return _account_of_scan(scan)._replace(is_one_text=True)


def _account_of_samples(result: nv.ScanArchive) -> Account:
    return _account_of_scan(result.request)


def _account_of_scan(scan: nv.Scan) -> Account:
    asked = [f"{name}: {words}" for name, words in scan.outline()]
    systems = [(scan.system, scan.system.in_words())]
    return Account(asked, systems, scan, assumed=AFTER_TRANSIENT)


_HISTORIES = nv.ResponseHistories, nv.LoadScan
_ACCOUNTS: Sequence[tuple[type, Callable[[Any], Account]]] = (
    (nv.ResponseHistories, _account_of_histories),
    (nv.LoadScan, _account_of_histories),
    (nv.ResponseCurves, _account_of_curves),
    (nv.Tuned, _account_of_tuning),
    (nv.Continued, _account_of_branches),
    (nv.Portrait, _account_of_portrait),
    (nv.Ensemble, _account_of_starts),
    (nv.ScanArchive, _account_of_samples),
)
"""The classes of results, and how each is told."""


def account_of(result: Any) -> Account:
    """Return what a page says of a result of any task."""
    for kind, account in _ACCOUNTS:
        if isinstance(result, kind):
            return account(result)
    raise nv.RequestError(f"{result} holds no result that a page can tell")


def special_points(
    result: nv.Continued, shown: Callable[[str], tuple[str, float]]
) -> list[tuple[str, ...]]:
    """Return the special points of branches as the rows of a table, the heading first.

    `shown` returns the name shown for a parameter, and the value [SI units] that is shown as 1.
    """
    rows: list[tuple[str, ...]] = [("kind", "at", "regime along the branch")]
    (name, one), *others = (shown(item.name) for item in result.request.free)
    for row in result.special_points:
        change = f"{row.before} → {row.after}" if row.before != row.after else str(row.before)
        if row.monitor:
            change += f"; {row.monitor}"
        rows.append((str(row.kind), f"{name} = {row.value / one:.8g}", change))
    for curve in result.curves:
        for kind, first, second in curve.meetings:
            (across, two), *_ = others
            place = f"{name} = {first / one:.6g}, {across} = {second / two:.6g}"
            rows.append((kind, place, f"on the curve of {curve.kind}, {curve.period}T"))
    return rows


def _results(result: Any, account: Account) -> str:
    lines = list(result.lines()) if hasattr(result, "lines") else []
    if lines and lines[0] == account.request.title:
        lines = lines[1:]
    history = account.history
    if history is not None:
        records = history.load.records_in_words(history.duration)
        lines = [line for line in lines if line not in records]
    if account.is_one_text:
        return f"<pre>{escape(chr(10).join(lines))}</pre>"
    table = ""
    if len(account.table) > 1:
        table = _table(account.table)
        of_table = {" ".join(" ".join(row).split()) for row in account.table}
        lines = [line for line in lines if " ".join(line.split()) not in of_table]
    return table + _listed(line.strip() for line in lines)


def _drawn(account: Account) -> str:
    shown = account.systems[:MOST_SYSTEMS]
    drawings = "".join(drawn_system(system, words) for system, words in shown)
    left = len(account.systems) - MOST_SYSTEMS
    more = f"<p>{left} more systems are not drawn.</p>" if left > 0 else ""
    return f'<div class="systems">{drawings}</div>{more}'


# ---- pictures ------------------------------------------------------------------------------------


def _pictures(path: Path, of_histories: bool) -> list[tuple[str | None, str]]:
    """Return the panels of each picture and its words; None for the usual panels."""
    names = nv.panels(path)
    shows: list[tuple[str | None, str]] = [(None, "usual picture")]
    if of_histories:
        ends = (".a", "peaks", ".stroke") if "peaks" in names else (
            "drift_ratio_max", "a_max", "a1_max", "stroke_max", "impact_count",
        )  # fmt: skip
        for end in ends:
            name = next((one for one in names if one.endswith(end)), None)
            if name is not None:
                shows.append((name, names[name]))
    return shows


def _picture(path: Path, show: str | None, words: str) -> str:
    """Return a picture of an archive as an image within the page; a line if it has none."""
    with tempfile.TemporaryDirectory() as folder:
        target = Path(folder) / "picture.svg"
        try:
            nv.plot(path, show, to=target)
        except nv.RequestError as error:
            return f"<p>{escape(words)}: {escape(str(error))}</p>"
        code = base64.b64encode(target.read_bytes()).decode("ascii")
    return f'<figure><img alt="{escape(words)}" src="data:image/svg+xml;base64,{code}"></figure>'


# ---- assumptions, and where it comes from --------------------------------------------------------


def assumptions_of(account: Account) -> Iterator[str]:
    """Yield what the numbers of a result rest on."""
    history = account.history
    systems = [system for system, _ in account.systems]
    yield "The structure is linear; dampers and walls are as drawn."
    if account.assumed:
        yield account.assumed
    if history is not None:
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
    names: dict[str, list[str]] = {}  # of the parameters that a text is about
    for system in systems:
        for name, text in system.assumptions.items():
            about = names.setdefault(text, [])
            if name not in about:
                about.append(name)
    for text, about in names.items():
        yield f"{', '.join(about)}: {text}"


def _provenance(path: Path, about: Mapping[str, str], account: Account) -> str:
    rows = [["archive", path.name], *([words, value] for words, value in about.items())]
    cells = "".join(
        f'<tr><th scope="row">{escape(one)}</th><td>{escape(value)}</td></tr>'
        for one, value in rows
    )
    request = escape(shortened(account.request.to_toml()))
    return (
        f"<table>{cells}</table><details><summary>The request (TOML); lists of more than "
        f"{MOST_NUMBERS} numbers are in the archive alone</summary><pre>{request}</pre></details>"
    )


_NUMBERS = re.compile(r"\[[^\[\]{}\"=]*\]")  # a list of numbers in TOML


def shortened(toml: str) -> str:
    """Return a request in which the number of its numbers stands in place of each long list."""
    return _NUMBERS.sub(_counted, toml)


def _counted(found: re.Match[str]) -> str:
    count = len(found[0].strip("[] \n,").split(","))
    return f'"{count} numbers, in the archive"' if count > MOST_NUMBERS else found[0]
