"""The tables and sentences of a survey say what was measured."""

from dataclasses import replace

import pytest
from made_up_curves import curve

from benchmarks.accuracy import page
from nlds_vines.accuracy import tables
from nlds_vines.accuracy.measured_cases import Measured, Result


def measured_case():
    ours = curve([(1e-3, 1e-3, 1e-6), (1e-7, 1e-7, 2e-6), (1e-12, 1e-13, 3e-6)], "exact")
    rival = curve([(1e-4, 1e-3, 1e-3), (1e-10, 1e-10, 2e-3)], "SciPy DOP853, events", ours=False)
    setting = replace(rival.results[0].setting, method="SciPy BDF")
    results = (*ours.results, *rival.results, Result(setting, failure="too stiff"))
    return Measured("a", "A case", "T,1", 20, "stored", 1e-15, 1e-12, "me", 1.0, results)


def test_the_tables_say_what_was_measured():
    case = measured_case()
    rows = "\n".join(tables.measurements(case))
    assert "| exact | 1e-07 steps | 1.0e-07 |" in rows
    assert "failed: too stiff" in rows
    assert page.verdict(case) == "`exact` is the cheapest at every error from 1e-03 to 1e-12."
    assert "SciPy DOP853, events" in "\n".join(page.ratios(case))
    assert '`method = "exact", tolerance = 1e-07`' in tables.advice(case, 1e-6)
    assert tables.advice(case, 1e-14).endswith("none was measured.")
    assert "](a.png)" in page.page([case], "a.png", "the command")


def test_the_verdict_names_the_cheaper_one():
    case = measured_case()
    cheap = curve([(1, 1e-13, 1e-9)], "heyoka, events", ours=False)
    found = page.verdict(replace(case, results=(*case.results, *cheap.results)))
    assert found.startswith("Cheaper than `exact`: heyoka, events at 1e-03")


def test_the_verdict_claims_no_more_than_was_reached():
    case = measured_case()
    ours, rival, broken = case.by_method().values()
    short = ours[:2]  # down to 1e-7
    found = page.verdict(replace(case, results=(*short, *broken)))
    assert found == "`exact` is the cheapest at every error from 1e-03 to 1e-07."
    assert page.verdict(replace(case, results=(*short, *rival))).startswith("Cheaper than `exact`")
    failed = tuple(replace(r, failure="no") for r in ours)
    for results in (ours, (*failed, *broken)):
        assert page.verdict(replace(case, results=results)).startswith("Nothing can be said")
    lines = [*page.summary(replace(case, results=(*failed, *rival)))]
    lines += page.ratios(replace(case, results=(*failed, *rival)))
    assert "inf" not in "".join(lines)
    assert "| 0 |" not in "".join(lines)


def test_the_verdict_names_the_blind():
    case = measured_case()
    cheap = curve([(1, 1e-13, 1e-9)], "numbalsoda", ours=False, missed=20.0)
    found = page.verdict(replace(case, results=(*case.results, *cheap.results)))
    assert found.startswith("`exact` is the cheapest")
    assert found.endswith("Cheaper, but blind: numbalsoda with 1 steps (20 missed, 1e-13).")
    assert page.verdict(case).endswith("1e-12.")


def test_every_table_row_has_as_many_cells_as_its_head():
    case = measured_case()
    for lines in (list(tables.measurements(case)), list(page.summary(case))):
        assert len({line.count("|") for line in lines}) == 1


@pytest.mark.parametrize(
    ("seconds", "words"), [(2.0, "2 s"), (3.14159e-3, "3.14 ms"), (1e-6, "1 us"), (5e-9, "5 ns")]
)
def test_durations(seconds, words):
    assert tables.duration(seconds) == words
