"""The survey of error against run time: every contender on every case."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from typing import Any

from nlds_vines.accuracy.cases import Case
from nlds_vines.accuracy.comparison_table import COLUMNS, SHAPE
from nlds_vines.accuracy.contenders import contenders
from nlds_vines.accuracy.measure import Truth, measured, truth_of
from nlds_vines.accuracy.reference import reference_of
from nlds_vines.accuracy.results import Result
from nlds_vines.accuracy.rivals import installed
from nlds_vines.accuracy.survey import Row, Survey, Task
from nlds_vines.archives.provenance import version


def comparison(cases: Sequence[Case], title: str, peers: bool = True) -> Survey:
    """Return the survey of all contenders on some cases, with the `peers` that are installed."""
    there = installed() if peers else ()
    about: dict[str, Any] = {
        "cases": {case.name: case.to_table() for case in cases},
        "peers": {peer.name: _version(peer.needs) for peer in there},
    }
    tasks = []
    for case in cases:
        truths: dict[str, Truth] = {}
        methods = dict.fromkeys(entry.setting.method for entry in contenders(case, peers))
        tasks += [
            Task(f"{case.name}: {method}", partial(_rows, case, method, peers, truths))
            for method in methods
        ]
    return Survey(title, SHAPE, about, COLUMNS, tuple(tasks))


def _rows(case: Case, method: str, peers: bool, truths: dict[str, Truth]) -> list[Row]:
    """Measure one method on a case; the truth about it is found once."""
    if case.name not in truths:
        truths[case.name] = truth_of(case, reference_of(case))
    truth = truths[case.name]
    chosen = (entry for entry in contenders(case, peers) if entry.setting.method == method)
    return [_row(truth, measured(truth, contender)) for contender in chosen]


def _row(truth: Truth, found: Result) -> Row:
    setting, reference = found.setting, truth.reference
    return {
        "case": truth.case.name,
        "title": truth.case.title,
        "truth": truth.label,
        "source": reference.source,
        "doubt": reference.doubt,
        "independent": reference.independent,
        "witness": reference.witness,
        "growth": reference.growth,
        "periods": truth.case.periods,
        "method": setting.method,
        "setting": setting.words,
        "value": setting.value,
        "ours": int(setting.ours),
        "expected_order": setting.order,
        "error": found.error,
        "touch_error": found.touch_error,
        "missed": found.missed,
        "energy_error": found.energy_error,
        "label": found.label,
        "seconds": found.seconds,
        "failure": found.failure,
        "status": int(bool(found.failure)),
    }


def _version(package: str) -> str:
    return version(package) if package else "of this program"
