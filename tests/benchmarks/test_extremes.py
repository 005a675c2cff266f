"""The catalogue of extremes: every promise is kept, and none of the checks keeps it by itself."""

import math
import re
from pathlib import Path

import numpy as np
import pytest

from benchmarks import extremes
from benchmarks.extremes import (
    CATALOGUE,
    Entry,
    bounds,
    cases,
    contacts,
    energy,
    flights,
    impacts,
    labels,
    proportions,
    reference,
    repetition,
    scales,
)
from benchmarks.extremes.command import main
from benchmarks.extremes.entry import Finding, within
from benchmarks.extremes.page import page
from nlds_vines import load_system, simulate
from nlds_vines.errors import RequestError
from nlds_vines.model.linear_response import flow_matrix
from nlds_vines.orbits.simulation import IntegrationError
from nlds_vines.runs.threads import most_threads

IDS = [f"{entry.number} {entry.name}" for entry in CATALOGUE]
SHORT = [
    pytest.param(entry, id=name, marks=[pytest.mark.long] if entry.long else [])
    for entry, name in zip(CATALOGUE, IDS, strict=True)
]


@pytest.mark.kernels
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


@pytest.mark.kernels
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


def stiffer(system, *how):
    """Follow an orbit of another system, by a millionth."""
    return reference.follow(system.with_(k1=system.parameters["k1"] * (1 + 1e-6)), *how)


def longer(system, power):
    return bounds.load_system(system.name, C=system.parameters["C"] * 1.001)


def wrong_if_exact(system, periods, method, follow=bounds.orbit_of):
    if method == "exact" and system.parameters["P"] != load_system("ssul-set6").parameters["P"]:
        system = system.with_(C=system.parameters["C"] * 1.001)
    return follow(system, periods, method=method)


def heavier(system, *how, exact=proportions.linear_sections, **options):
    if system.name == "none":
        system = system.with_(m1=system.parameters["m1"] * 1.001)
    return exact(system, *how, **options)


def refused(*arguments, **options):
    raise IntegrationError("too_stiff")


steady, stored = flights.steady_state, cases.stored_section
MOVED = {"cases.stored_section": lambda case: stored(case) * (1 + 1e-6)}
FAULTS = {  # what is wrong: the check that must see it, where it is put, and words of the finding
    "an orbit of another system": (contacts.preloaded, {"contacts.follow": stiffer}, ""),
    "a closed form": (
        flights.far_wall, {"flights.steady_state": lambda system: steady(system) * (1 + 1e-9)}, "",
    ),
    "what passes for a result": (
        bounds.overflow, {"bounds.NAMES": ("none", "tmd"), "bounds.BEYOND": (1e100,)}, "",
    ),
    "a length, of one method": (bounds.lengths, {"bounds.orbit_of": wrong_if_exact}, "exact"),
    "an order of magnitude": (bounds.lengths, {"bounds.enlarged": longer}, ""),
    "a damper that is not welded": (
        proportions.enormous_damping, {"proportions.linear_sections": heavier}, "",
    ),
    "a stored state, across contacts": (impacts.order_across_contacts, MOVED, ""),
    "a stored state, in impacts": (impacts.nodes_of_short_impacts, MOVED, ""),
    "a trace": (labels.volumes, {"labels._trace": lambda system: -1.35}, ""),
}  # fmt: skip
LIGHT = {
    "a bad number that is let in": (
        bounds.refused_at_the_door, {"bounds._outside": lambda parameter: iter([1.0])}, "",
    ),
    "no orbit that shows a rigid impact": (
        bounds.rigid_beyond_numbers, {"bounds.orbit_of": refused}, "0 of 10 orbits ran",
    ),
    "no orbit that shows a proportion": (
        bounds.out_of_all_proportion, {"bounds.simulate": refused}, "exact: 0 ran",
    ),
    "an unconfirmed refinement": (
        impacts.order_of_stepped_contacts, {"impacts.follow": stiffer}, "",
    ),
    "a lane that is not marked": (
        repetition.bad_lanes,
        {"repetition.MUST_BE_FINITE": (), "repetition.MUST_BE_POSITIVE": (),
         "repetition.MUST_NOT_BE_NEGATIVE": ("near",)},  # preloaded: allowed
        "",
    ),
}  # fmt: skip


@pytest.mark.parametrize(
    "fault", [*(pytest.param(fault, marks=pytest.mark.kernels) for fault in FAULTS), *LIGHT]
)
def test_what_is_wrong_is_seen(fault, monkeypatch):
    check, places, words = (FAULTS | LIGHT)[fault]
    for place, value in places.items():
        monkeypatch.setattr(f"benchmarks.extremes.{place}", value)
    finding = check()
    assert not finding.passed
    assert words in finding.words
    assert fault != "what passes for a result" or finding.measured > 10


def test_what_is_not_stored_is_told():
    with pytest.raises(RequestError, match=r"omega = 6\.5: no state is stored"):
        cases.stored_state(load_system("ssul-set6", omega=6.5), 5)


def test_the_threads_that_were_used_are_told():
    most = most_threads()
    counts = sorted({min(threads, most) for threads in repetition.THREADS})
    assert f"(threads: {', '.join(map(str, counts))})" in repetition.whatever_the_order().words


def test_a_wrong_order_is_fitted_as_such():
    steps = [8.0, 16.0, 32.0]
    assert cases.order_of([n**-3 for n in steps], steps) == pytest.approx(3.0)


def test_scales_of_errors_are_those_of_positions_and_speeds():
    exact = np.array([[1.0, 100.0, 5.0, 0.0]])
    for found, error in (([1.0, 101.0, 5.0, 0.0], 0.01), ([1.0, 100.0, 6.0, 0.0], 1.0)):
        assert cases.error_of(np.array([found]), exact, 5.0) == pytest.approx(error)


def test_an_error_that_is_no_number_is_the_largest():
    exact = np.array([[1.0, 100.0, 5.0, 0.0]])
    for found in ([math.nan, 100.0, 5.0, 0.0], [1.0, 100.0, 5.0, math.nan]):
        assert max(1.0, cases.error_of(np.array([found]), exact)) == math.inf


@pytest.mark.parametrize("name", ["none", "tmd", "ssul-set6"])
def test_the_matrix_of_the_flight_is_the_equation_of_motion(name):
    system, time = load_system(name), 0.3
    p = {"m2": 1.0, "k2": 0.0, "c2": 0.0, **system.parameters}
    x1, v1, r2, v2 = 0.01, -0.2, 0.03, 0.4
    phase = p["omega"] * time
    pull = p["k2"] * (x1 - r2) + p["c2"] * (v1 - v2)
    force = p["P"] * math.cos(phase) - p["k1"] * x1 - p["c1"] * v1
    turning = -p["omega"] * math.sin(phase), p["omega"] * math.cos(phase)
    expected = [v1, (force - pull) / p["m1"], v2, pull / p["m2"], *turning]
    y = np.array([x1, v1, r2, v2, math.cos(phase), math.sin(phase)])
    np.testing.assert_allclose(flow_matrix(system) @ y, expected, rtol=1e-14)


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


def raising(error):
    def check():
        raise error

    return Entry(2, "second thing", "The second thing holds.", check)


def test_a_check_that_raises_is_a_broken_promise_and_the_next_follows(here, monkeypatch, capsys):
    error = IntegrationError("too_stiff at lane 3.\nRaise omega")
    monkeypatch.setattr(extremes, "CATALOGUE", (KEPT, raising(error), raising(KeyError()), KEPT))
    assert main(["--quiet"]) == 1
    text = capsys.readouterr().out
    assert "2 of 4 promises are kept" in " ".join(text.split())
    assert "Measured: IntegrationError: too_stiff at lane 3 (**broken**)." in text
    assert "Measured: KeyError (**broken**)." in text
    assert re.search(r"^\| 2 \| second thing \| +nan \| +nan \| \*\*broken\*\* \|$", text, re.M)
    assert "Raise omega" not in text


def test_an_interrupt_is_no_finding():
    with pytest.raises(KeyboardInterrupt):
        list(extremes.findings([raising(KeyboardInterrupt())]))


def test_a_broken_promise_is_status_1_and_the_page_is_written(here, monkeypatch, capsys):
    monkeypatch.setattr(extremes, "CATALOGUE", (KEPT, BROKEN, LENGTHY))
    assert main(["--quiet", "--markdown", "extremes.md"]) == 1
    out, err = capsys.readouterr()
    assert err == ""
    text = Path("extremes.md").read_text()
    assert text.startswith(out)
    assert text.endswith("\n```sh\npython -m benchmarks.extremes --markdown extremes.md\n```\n")
    assert "third thing" not in text


def test_kept_promises_are_status_0_and_are_told_as_they_come(here, monkeypatch, capsys):
    monkeypatch.setattr(extremes, "CATALOGUE", (KEPT, LENGTHY))
    assert main(["--long"]) == 0
    out, err = capsys.readouterr()
    assert "third thing" in out
    assert [line.partition(":")[0] for line in err.splitlines()] == [
        "1/2 1 first thing",
        "2/2 3 third thing",
    ]


def test_a_dry_run_lists_and_checks_nothing(here, monkeypatch, capsys):
    def never():
        raise AssertionError

    monkeypatch.setattr(extremes, "CATALOGUE", (Entry(1, "first thing", "", never), LENGTHY))
    assert main(["--dry-run"]) == 0
    assert capsys.readouterr().out == "1 first thing\n"


def test_a_page_that_cannot_be_written_is_refused_before_anything_is_checked(here, capsys):
    assert main(["--markdown", "no/x.md"]) == 2
    assert "--markdown" in capsys.readouterr().err
