"""The catalogue of extremes: every promise is kept, and none of the checks keeps it by itself."""

import math
import re
from pathlib import Path

import numpy as np
import pytest

from nlds_vines import extremes, load_system, simulate
from nlds_vines.accuracy import main
from nlds_vines.extremes import (
    CATALOGUE,
    Entry,
    bounds,
    cases,
    contacts,
    energy,
    flights,
    labels,
    reference,
    repetition,
    scales,
)
from nlds_vines.extremes.entry import Finding, within
from nlds_vines.extremes.page import page

IDS = [f"{entry.number} {entry.name}" for entry in CATALOGUE]
SHORT = [
    pytest.param(entry, id=name, marks=[pytest.mark.long] if entry.long else [])
    for entry, name in zip(CATALOGUE, IDS, strict=True)
]


@pytest.mark.parametrize("entry", SHORT)
def test_the_promise_is_kept(entry):
    finding = entry.check()
    assert finding.passed, finding.words
    assert finding.measured <= finding.bound
    assert finding.words


def test_the_catalogue_is_complete_and_in_order():
    numbers = [entry.number for entry in CATALOGUE]
    assert numbers == sorted(numbers)
    assert set(numbers) == set(range(1, 30))
    assert len(set(IDS)) == len(IDS)


def test_what_is_promised_is_a_sentence():
    for entry in CATALOGUE:
        assert entry.promise.endswith("."), entry.name
        assert not entry.limit or entry.limit.endswith("."), entry.name


# ---- checks can fail -----------------------------------------------------------------------------


def test_no_number_passes():
    assert not within(math.nan, 1.0, "").passed
    assert not within(math.inf, 1.0, "").passed
    assert within(1.0, 1.0, "").passed


def test_what_is_not_scaled_is_seen():
    def half_scaled(system, power):
        return scales.scaled(system, power).with_(K=system.K)

    finding = scales.scaling_of_forces(half_scaled)
    assert not finding.passed
    assert finding.measured > 6


def test_a_lost_joule_is_seen():
    system = load_system("ssul-set6")
    states = simulate(system, energy.PERIODS).section
    (last,) = cases.energy_of(system, states[-1:])
    sound, short = energy.ledger(system, [last, last - 1.0])
    assert sound < 1e-8
    assert short > 1e-4


def test_an_orbit_of_another_system_is_seen(monkeypatch):
    follow = reference.follow

    def another(system, periods, start=None):
        return follow(system.with_(k1=system.parameters["k1"] * (1 + 1e-6)), periods, start)

    monkeypatch.setattr(contacts, "follow", another)
    assert not contacts.preloaded().passed


def test_a_wrong_closed_form_is_seen(monkeypatch):
    steady = flights.steady_state
    monkeypatch.setattr(flights, "steady_state", lambda system: steady(system) * (1 + 1e-9))
    assert not flights.far_wall().passed


def test_what_passes_for_a_result_is_seen(monkeypatch):
    monkeypatch.setattr(bounds, "NAMES", ("none", "tmd"))
    monkeypatch.setattr(bounds, "BEYOND", (1e100,))
    finding = bounds.overflow()
    assert not finding.passed
    assert finding.measured > 10


def test_a_bad_number_that_is_let_in_is_seen(monkeypatch):
    monkeypatch.setattr(bounds, "_outside", lambda parameter: iter([1.0]))
    assert not bounds.refused_at_the_door().passed


def test_a_lane_that_is_not_marked_is_seen(monkeypatch):
    monkeypatch.setattr(repetition, "MUST_BE_FINITE", ())
    monkeypatch.setattr(repetition, "MUST_BE_POSITIVE", ())
    monkeypatch.setattr(repetition, "MUST_NOT_BE_NEGATIVE", ("near",))  # preloaded: allowed
    assert not repetition.bad_lanes().passed


def test_another_order_of_magnitude_is_seen(monkeypatch):
    def longer(system, power):
        return bounds.load_system(system.name, C=system.parameters["C"] * 1.001)

    monkeypatch.setattr(bounds, "enlarged", longer)
    assert not bounds.lengths().passed


def test_a_wrong_trace_is_seen(monkeypatch):
    monkeypatch.setattr(labels, "_trace", lambda system: -1.35)
    assert not labels.volumes().passed


def test_a_wrong_order_is_fitted_as_such():
    steps = [8.0, 16.0, 32.0]
    assert cases.order_of([n**-3 for n in steps], steps) == pytest.approx(3.0)


def test_scales_of_errors_are_those_of_positions_and_speeds():
    exact = np.array([[1.0, 100.0, 5.0, 0.0]])
    for found, error in (([1.0, 101.0, 5.0, 0.0], 0.01), ([1.0, 100.0, 6.0, 0.0], 1.0)):
        assert cases.error_of(np.array([found]), exact, 5.0) == pytest.approx(error)


# ---- the page and the command --------------------------------------------------------------------


def entry_of(number, name, passed, limit="", long=False):
    finding = Finding(0.0 if passed else 2.0, 0.5, passed, f"{name} was looked at")
    return Entry(number, name, f"The {name} holds.", lambda: finding, limit, long)


KEPT = entry_of(1, "first thing", True, "Numbers end.")
BROKEN = entry_of(2, "second thing", False)
LENGTHY = entry_of(3, "third thing", True, long=True)


def test_the_page_tells_everything_once():
    text = "\n".join(page([(entry, entry.check()) for entry in (KEPT, BROKEN)]))
    assert "1 of 2 promises are kept" in " ".join(text.split())
    for heading in ("## 1. First thing", "## 2. Second thing"):
        assert text.count(heading) == 1
    assert text.count("Why not more: Numbers end.") == 1
    assert re.search(r"^\| 2 \| second thing \| +2 \| +0\.5 \| \*\*broken\*\* \|$", text, re.M)
    assert max(map(len, text.splitlines())) <= 100


def test_findings_are_made_one_at_a_time():
    checked = []

    def check():
        checked.append(1)
        return Finding(0.0, 0.0, True, "")

    entries = [Entry(1, "a", "A.", check), Entry(2, "b", "B.", check)]
    found = extremes.findings(entries)
    assert not checked
    next(found)
    assert len(checked) == 1


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    return tmp_path


def test_a_broken_promise_is_status_1_and_the_page_is_written(folder, monkeypatch, capsys):
    monkeypatch.setattr(extremes, "CATALOGUE", (KEPT, BROKEN, LENGTHY))
    assert main(["--extreme", "--quiet", "--markdown", "extremes.md"]) == 1
    out, err = capsys.readouterr()
    assert err == ""
    text = Path("extremes.md").read_text()
    assert text.startswith(out)
    assert text.endswith(
        "\n```sh\npython -m nlds_vines.accuracy --extreme --markdown extremes.md\n```\n"
    )
    assert "third thing" not in text


def test_kept_promises_are_status_0_and_are_told_as_they_come(folder, monkeypatch, capsys):
    monkeypatch.setattr(extremes, "CATALOGUE", (KEPT, LENGTHY))
    assert main(["--extreme", "--long"]) == 0
    out, err = capsys.readouterr()
    assert "third thing" in out
    assert [line.partition(":")[0] for line in err.splitlines()] == [
        "1/2 1 first thing",
        "2/2 3 third thing",
    ]


def test_a_dry_run_lists_and_checks_nothing(folder, monkeypatch, capsys):
    def never():
        raise AssertionError

    monkeypatch.setattr(extremes, "CATALOGUE", (Entry(1, "first thing", "", never), LENGTHY))
    assert main(["--extreme", "--dry-run"]) == 0
    assert capsys.readouterr().out == "1 first thing\n"


def test_a_page_that_cannot_be_written_is_refused_before_anything_is_checked(folder, capsys):
    assert main(["--extreme", "--markdown", "no/x.md"]) == 2
    assert "--markdown" in capsys.readouterr().err
