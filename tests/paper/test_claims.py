"""Claims in invented worlds: every check can hold and can fail, and reports what it measured."""

import re
from dataclasses import replace

import numpy as np
import paper_results
import pytest
from commands import printed
from paper_results import RESULTS, MadeUp, is_at, unchanging, where

import nlds_vines as nv
from nlds_vines.engine.one_orbit import IntegrationError
from nlds_vines.model.system import System
from nlds_vines.portrait.request import load_portrait
from nlds_vines.portrait.run import views_of
from paper import claims_page, motion
from paper.claims import CLAIMS, FACTS, Data, Missing, Verdict, archived, judge
from paper.claims.claim import maxima, spans, weighed
from paper.claims.free_movement import LIMITS, best_within, passage, taken_by_set_6
from paper.claims.measured import Breadth, not_followed
from paper.claims.published_optima import near
from paper.command import main
from paper.motion import motion_of, motions_of
from paper.request import load_figure, packaged_figures

ALL = (*CLAIMS, *FACTS)
NEVER_DECIDED = {  # the paper is silent
    "The moduli, the surfaces' geometry and equation (4) fix the contact stiffness K.",
    "The values of k1 that were compared.",
}


@pytest.mark.parametrize("claim", ALL, ids=lambda claim: claim.statement)
def test_every_check_can_fail_and_can_hold(claim):
    words = {judge(claim, evidence).verdict for evidence in RESULTS.values()}
    if claim.statement in NEVER_DECIDED:
        assert words == {Verdict.OPEN}
    else:
        assert {Verdict.AGREE, Verdict.DIFFER} <= words


def test_claims_name_place_figure_and_one_line_and_load_no_kernel():
    printed("-c", "import sys, paper.claims, paper.report; sys.exit('numba' in sys.modules)")
    for claim in ALL:
        assert claim.where
        assert claim.figure in paper_results.requests()
        text = judge(claim, RESULTS["published"]).text
        assert text
        assert "\n" not in text
    assert len({claim.statement for claim in ALL}) == len(ALL)


def test_what_was_not_computed_is_said_to_be(tmp_path):
    evidence = archived(paper_results.requests(), tmp_path)
    judgments = [judge(claim, evidence) for claim in ALL]
    # the only one that needs nothing computed is about what is not printed
    assert [f.verdict for f in judgments].count(Verdict.NOT_RUN) == len(ALL) - 1
    with pytest.raises(Missing, match="no curve"):
        evidence("3", "ssul-set1")


def test_a_doctored_archive_changes_the_verdict(tmp_path):
    claim = next(claim for claim in CLAIMS if "Sets 1 and 2" in claim.statement)
    request, published = paper_results.requests()["2a"], RESULTS["published"]
    path = paper_results.write_figure(tmp_path, "2a", published)
    assert judge(claim, archived(paper_results.requests(), tmp_path)).verdict == Verdict.AGREE
    path.unlink()
    numbers = {name: published("2a", name).numbers for name in request.scans}
    numbers["ssul-set2"] = {
        name: values * 1.1
        for name, values in numbers["ssul-set2"].items()
        if name in ("E1max", "E2max")
    }
    paper_results.write_curves(path, request.computed, list(numbers.values()))
    judgment = judge(claim, archived(paper_results.requests(), tmp_path))
    assert judgment.verdict == Verdict.DIFFER
    assert judgment.text == "at most 10.0 % of the peak apart"


def test_places_maxima_and_spans():
    system = System("none", {"m1": 1, "k1": 1, "c1": 1, "P": 1, "omega": 1})
    data = Data(system, {"omega": np.arange(3.0)}, {})
    with pytest.raises(Missing, match=r"0\.5 rad/s"):  # off the grid
        data.place(0.5)
    with pytest.raises(Missing, match="not recorded"):
        data.peak()
    values = np.array([0, 5, 1, 10, 10, 0, 2, 1.0])
    np.testing.assert_array_equal(maxima(values, 0.3), [1, 3])
    assert spans(np.arange(5.0), np.array([1, 1, 0, 0, 1], bool)) == [(0, 1), (4, 4)]
    assert spans(np.arange(2.0), np.zeros(2, bool)) == []


AGREE, PART, DIFFER, OPEN = Verdict.AGREE, Verdict.PART, Verdict.DIFFER, Verdict.OPEN


def claim_of(words):
    (match,) = (claim for claim in CLAIMS if words in claim.statement)
    return match


def test_a_claim_agrees_in_part_where_some_measures_hold():
    verdicts = [weighed("text", *holds).verdict for holds in ((1, 1), (1, 0), (0, 0), (np.True_,))]
    assert verdicts == [AGREE, PART, DIFFER, AGREE]


JUDGED = {
    # designs and surface (section 2)
    "strikes the obstacle and the structure": {"published": AGREE, "other orbits": DIFFER},
    "(Figure 1b) hardly mitigates": {"published": AGREE, "better designs": DIFFER},
    "A soft surface of the damper is better": {"published": AGREE, "contrary": DIFFER},
    "E2 = 2.05e7 Pa is the optimum": {"published": AGREE, "contrary": DIFFER},
    "A soft surface makes impacts softer": {"published": AGREE, "other orbits": DIFFER},
    # optima
    "Sets 3 to 6 are optima": {"published": AGREE, "all_different": PART, "better designs": DIFFER},
    "So is the SSbl NES of Table 2": {"published": AGREE, "better designs": DIFFER},
    "Many sets of parameters": {"published": AGREE, "worse designs": DIFFER},
    # parameter sets and three dampers (section 3)
    "Set 6 is slightly the most effective": {"contrary": DIFFER},
    "Sets 3 to 6 reduce the energy similarly": {"published": AGREE, "all_different": PART},
    "The damper's own energy is large": {"published": AGREE, "rising": DIFFER},
    "2T, 3T, 4T with 1, 2, 3 impacts": {"in turns": AGREE, "published": PART, "unchanging": DIFFER},
    "One K gives 3T,3": {"published": AGREE, "other K": PART, "unchanging": DIFFER},
    "The damper moves far away": {"published": AGREE, "other orbits": DIFFER},
    "SSbl NES and TMD are only slightly less": {"published": DIFFER, "unchanging": AGREE},
    # stiffness (section 4.1)
    "Any change of the stiffness": {"contrary": AGREE, "published": PART, "unchanging": DIFFER},
    "costs much less than a softer one": {"published": AGREE, "unchanging": DIFFER},
    "A softer structure costs all three much": {"published": PART},
    # damping and force (sections 4.2, 4.3, 7)
    "Changing c1 hardly matters": {"unchanging": AGREE, "contrary": DIFFER},
    "Changing P hardly matters": {"published": AGREE, "contrary": DIFFER},
    "With c1 changed, the reduction": {"unchanging": AGREE, "contrary": DIFFER},
    "With P changed, the reduction": {"published": PART, "unchanging": AGREE},
    "Changing c1 leaves the dynamics": {"published": AGREE, "restless": DIFFER},
    "Changing P leaves the dynamics": {"published": AGREE, "restless": DIFFER},
    "A change of P acts as one of c1 does": {
        "unchanging": AGREE, "published": PART, "restless": PART, "contrary": DIFFER,
    },
    "keep their tuning alike": {"unchanging": AGREE, "published": PART, "contrary": DIFFER},
    # dynamics (sections 5 and 7)
    "T,1 covers almost the whole range": {"unchanging": AGREE, "published": PART},
    "What follows is chaos": {"chaos": AGREE, "published": DIFFER},
    "Irregular motion does not spoil": {
        "published": AGREE, "rising": PART, "without period": PART, "spoiled": DIFFER,
    },
    # single orbits (section 5)
    "three impacts of a cycle": {"published": AGREE, "other orbits": DIFFER},
    "is a smear": {"published": AGREE, "other orbits": DIFFER},
    "broad and continuous": {"published": AGREE, "other orbits": DIFFER},
}  # fmt: skip


@pytest.mark.parametrize(("words", "expected"), JUDGED.items())
def test_verdicts_in_invented_worlds(words, expected):
    judgments = {world: judge(claim_of(words), RESULTS[world]) for world in expected}
    assert {world: one.verdict for world, one in judgments.items()} == expected, judgments


def tuned_alone(system, omega):
    """65, 61, 59 and 72 % off the peak, 95 % off where tuned, as the program finds them."""
    peaks = {0.06: 548.0, 0.08286: 612.0, 0.09975: 643.0, 0.06233: 439.0}
    if not system.scene.walls:
        return paper_results.bell(omega, 1568, 6.28)
    return paper_results.bell(omega, peaks.get(system.parameters["C"], 670), 5.7) + 78


def large_where_tuned(omega):
    return np.where(np.abs(omega - 6.28) < 0.3, 1.5, 0.8)


def best_by_peak(system, omega):
    """Set 6 is the best by its peak, and not where tuned."""
    is_six = system.parameters.get("k2") == 668.9
    peak, there = (400, 90) if is_six else (500, 80)
    return np.where(np.abs(omega - 5.7) < 0.2, peak, there)


def growing(system, omega):
    """As much is taken off, but of more."""
    return unchanging(system, omega) * (452.0 / system.parameters["c1"]) ** 2


def only_at(K):
    """Return a world in which no other K gives the regime at 7.375 rad/s."""

    def place(system, omega, label):
        return is_at(omega, 7.375) & (abs(system.K / K - 1) > 1e-6)

    return MadeUp(regimes=where(place, 1, 1, "T,1"))


def labelled(word):
    return MadeUp(regimes=where(lambda _, w, label: is_at(w, 7.375), n=0, label=word))


def chaotic_only(chosen):
    def place(system, omega, label):
        return np.array(["chaos" in word and word != chosen for word in label])

    return MadeUp(regimes=where(place, label="T,1"))


def bursting(burst):
    """Return a world whose chaos has so many times the energy of the regular motion beside it."""

    def energy(system, omega):
        irregular = paper_results.motion(system, omega)[2] == "chaos"
        bell = paper_results.bell(omega, 50, 7.4, 2)
        return np.where(irregular, burst, 1.0) * bell + 400 * (omega < 6)

    regular = where(lambda _, w, label: label == "undetermined", n=1, label="T,1")
    return MadeUp(energy, regimes=regular)


def smeared(**breadths):
    """Return a world in which the orbit of Figure 10 has other spectra."""
    (motion,) = paper_results.as_published("10")
    seen = replace(motion, breadths={**motion.breadths, **breadths})
    return MadeUp(orbits=lambda _: [seen])


LINES, FLOOR = Breadth(3, 0.04, 31, 32), Breadth(3, 0.8, 32, 32)
SPECIAL = [
    ("Sets 3 to 6 reduce", MadeUp(tuned_alone), PART, ""),
    ("The damper's own energy is large", MadeUp(damper=large_where_tuned), PART, ""),
    ("Set 6 is slightly the most", MadeUp(best_by_peak), PART, "Set 6 the last of Sets 3 to 6"),
    ("With c1 changed, the reduction", MadeUp(growing), PART, "ssbl 1.65, 1.00, 0.67"),
    ("3T,3 at 7.375 rad/s.", only_at(2.5e7), PART, ""),
    ("3T,3 at 7.375 rad/s.", only_at(1.0), DIFFER, ""),
    ("3T,3 at 7.375 rad/s.", labelled("undetermined"), OPEN, "^undetermined with the assumed"),
    ("3T,3 at 7.375 rad/s.", labelled("quasiperiodic"), DIFFER, "^quasiperiodic with the assumed"),
    ("2T, 3T, 4T with 1, 2, 3 impacts", only_at(2.5e7), PART, ""),
    ("2T, 3T, 4T with 1, 2, 3 impacts", only_at(1.0), DIFFER, ""),
    ("Among them are chaotic motions", chaotic_only("chaos"), PART, ""),
    ("Among them are chaotic motions", chaotic_only("transient chaos to T,0"), PART, ""),
    ("Among them are chaotic motions", MadeUp(), AGREE, ""),
    ("Irregular motion", bursting(1.1), AGREE, "up to 1.10 times"),
    ("Irregular motion", bursting(1.3), PART, "up to 1.30 times"),
    ("hardly mitigates", MadeUp(design=paper_results.better_design, violations=1), AGREE,
     "^none of 500 designs keeps x1 < x2$"),
    ("broad and continuous", smeared(x2=LINES), PART, ""),
    ("broad and continuous", smeared(x2=FLOOR, force=FLOOR), PART, ""),
]  # fmt: skip


@pytest.mark.parametrize(("words", "world", "expected", "text"), SPECIAL)
def test_verdicts_in_special_worlds_say_both_sides(words, world, expected, text):
    judgment = judge(claim_of(words), world)
    assert judgment.verdict == expected, judgment.text
    assert re.search(text, judgment.text)


def test_near_a_design_means_all_of_its_parameters():
    data = MadeUp()("tuned-ssbl")
    around = near(data, {"C": 0.36, "c2": 232.0}, 0.04)
    C, c2 = np.meshgrid(data.axes["C"], data.axes["c2"], indexing="ij")
    expected = (np.abs(C / 0.36 - 1) <= 0.04) & (np.abs(c2 / 232 - 1) <= 0.04)
    np.testing.assert_array_equal(around, expected)
    assert 0 < around.sum() < around.size


@pytest.mark.slow("a page of 1201 orbits")
def test_the_page_has_the_diagram_and_every_claim(tmp_path, monkeypatch):
    pytest.importorskip("bokeh")
    monkeypatch.setattr(claims_page, "motions_of", not_followed)
    requests = paper_results.requests()
    paper_results.write_figure(tmp_path, "8", RESULTS["published"])
    output = tmp_path / "page.html"
    claims_page.write_page(output, tmp_path, requests, requests["8"].archive)
    html = output.read_text(encoding="utf-8")
    table = html[html.index("<h2>The claims of the paper</h2>") :]
    assert table[: table.index("</table>")].count("<tr><td>") == len(CLAIMS)
    assert "not computed" in table


def test_a_page_without_its_figure_is_refused(here, capsys):
    pytest.importorskip("bokeh")
    assert main(["--only", "3", "--page", "page.html"]) == 2
    assert "--page shows figure 8" in capsys.readouterr().err
    (here / "page.html").write_text("mine")
    assert main(["--page", "page.html"]) == 2
    assert "page.html" in capsys.readouterr().err
    assert (here / "page.html").read_text() == "mine"


# ---- what claims are measured by -----------------------------------------------------------------


def test_motion_is_that_of_the_last_cycle_and_its_spectra_are_lines():
    numbers = {"omega": 7.375, "K": 2.5e7}
    sampling = {"samples": 64, "transient": 2000, "periods": 48}
    portrait = {"system": "ssul-set6", "set": numbers, "sampling": sampling}
    (view,) = views_of(load_portrait(portrait))
    motion = motion_of(view)
    impacts = nv.simulate(nv.load_system("ssul-set6", **numbers), 3, transient=2045).impacts
    assert motion.label == "3T,3"
    np.testing.assert_allclose(motion.forces, impacts["force"], rtol=1e-6)
    np.testing.assert_allclose(motion.durations, impacts["release"] - impacts["touch"], rtol=1e-6)
    assert motion.section.shape == (48, 4)
    assert -0.07 < motion.least < -0.06233  # the clearance, and the depth of the deepest impact
    assert motion.greatest > 0.2
    for breadth in motion.breadths.values():  # whatever the window
        assert breadth.comb == 3
        assert breadth.share < 1e-6
        assert breadth.bins == breadth.bins_of_half


def test_orbits_are_those_of_the_request(tmp_path):
    path = tmp_path / "orbit.toml"
    path.write_text("""
system = "ssul-set6"
sampling = { samples = 32 }
portrait = { panels = ["force"] }
column = [
    { set = { omega = 6.28 }, window = [20, 32] },
    { set = { omega = 7.45, K = 2.5e7 }, window = [20, 32] },
]
""")
    first, second = motions_of(load_figure(path))
    assert first.system.parameters["omega"] == 6.28
    assert second.system.K == 2.5e7
    assert not second.label  # a transient
    assert len(second.forces) > 3  # all of the window


def test_an_orbit_that_ends_early_leaves_its_claims_open(monkeypatch):
    def fail(request):
        raise IntegrationError("too many impacts")

    monkeypatch.setattr(motion, "views_of", fail)
    with pytest.raises(Missing, match="figure9: too many impacts"):
        motions_of(paper_results.requests()["9"])


def data(axes, energy, depth):
    violations = np.where(np.isfinite(depth), 3, 0)
    numbers = {"E1max": energy, "violation_depth": depth, "violations": violations}
    return Data(nv.load_system("ssul-set6"), axes, numbers)


def test_the_best_of_the_dampers_that_keep_a_limit_is_told():
    axes = {"k2": np.array([300.0, 400.0]), "c2": np.array([25.0, 50.0])}
    energy, depth = [[40.0, 60.0], [80.0, 90.0]], [[0.7, 0.35], [0.15, np.nan]]
    map_of = data(axes, np.array(energy), np.array(depth))
    assert passage(map_of).tolist() == [[0.7, 0.35], [0.15, 0.0]]
    rows = list(best_within(lambda name: map_of))
    assert len(rows) == len(LIMITS)
    assert set(rows) >= {
        ("0", "90.0", "400", "50", "1 of 4"), ("0.2", "80.0", "400", "25", "2 of 4"),
        ("0.4", "60.0", "300", "50", "3 of 4"), ("0.8", "40.0", "300", "25", "4 of 4"),
    }  # fmt: skip


def test_what_set_6_takes_is_told_where_tuned_at_its_peak_and_at_most():
    axes = {"omega": np.array([6.0, 6.28, 7.0]), "k1": np.array([3e4])}
    energy, depth = np.array([[500.0], [90.0], [200.0]]), np.array([[0.6], [0.5], [0.7]])
    study = data(axes, energy, depth)
    assert list(taken_by_set_6(lambda name: study)) == [
        ("30000", "500.0", "6", "0.500", "0.600", "0.700")
    ]
    off = data({**axes, "omega": np.array([6.0, 6.2, 7.0])}, energy, depth)
    with pytest.raises(Missing, match=r"6\.28"):
        list(taken_by_set_6(lambda name: off))


def test_the_studies_are_those_of_set_6_in_another_place():
    six = nv.load_system("ssul-set6").parameters
    for name in ("study-model-1c", "study-free-movement"):
        (request,) = (one for one in packaged_figures().values() if one.name == name)
        (scan,) = request.scans.values()
        p = scan.system.parameters
        assert scan.system.kind == "ssvi-c"
        assert p["L"] == 0.0
        assert {key: p[key] for key in six if key in p} == {k: v for k, v in six.items() if k in p}
