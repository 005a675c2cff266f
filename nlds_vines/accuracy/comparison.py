"""The survey of error against run time: every contender on every case."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from typing import Any

from nlds_vines.accuracy.cases import Case
from nlds_vines.accuracy.columns import Row, row_of
from nlds_vines.accuracy.comparison_table import COLUMNS, SHAPE, Followed
from nlds_vines.accuracy.contenders import contenders
from nlds_vines.accuracy.measure import Truth, measured, truth_of
from nlds_vines.accuracy.reference import reference_of
from nlds_vines.accuracy.rivals import Rival
from nlds_vines.accuracy.survey import Survey, Task


def comparison(cases: Sequence[Case], title: str, rivals: Sequence[Rival]) -> Survey:
    """Return the survey of our methods and of `rivals`, which are installed, on some cases."""
    about: dict[str, Any] = {
        "cases": {case.name: case.to_table() for case in cases},
        "peers": {rival.name: rival.version() or "of this program" for rival in rivals},
    }
    tasks = []
    for case in cases:
        truths: dict[str, Truth] = {}
        methods = dict.fromkeys(entry.setting.method for entry in contenders(case, rivals))
        tasks += [
            Task(f"{case.name}: {method}", partial(_rows, case, method, rivals, truths))
            for method in methods
        ]
    return Survey(title, SHAPE, about, COLUMNS, tuple(tasks))


def _rows(case: Case, method: str, rivals: Sequence[Rival], truths: dict[str, Truth]) -> list[Row]:
    """Measure one method on a case; the truth about it is found once."""
    if case.name not in truths:
        truths[case.name] = truth_of(case, reference_of(case))
    truth = truths[case.name]
    followed = Followed(case.name, case.title, truth.label, case.periods)
    chosen = (entry for entry in contenders(case, rivals) if entry.setting.method == method)
    results = (measured(truth, contender) for contender in chosen)
    return [row_of(followed, truth.reference, found.setting, found) for found in results]
