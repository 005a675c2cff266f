"""Claims: every check that can be decided can hold and can fail, and reports what it measured."""

import subprocess
import sys

import numpy as np
import paper_results
import pytest
from paper_worlds import RESULTS
from support import REPO

from nlds_vines.model.system import System
from paper.claims import CLAIMS, FACTS, Data, Missing, Verdict, archived, judge
from paper.claims.claim import maxima, spans

ALL = (*CLAIMS, *FACTS)
NEVER_DECIDED = {  # the paper is silent
    "The moduli, the surfaces' geometry and equation (4) fix the contact stiffness K.",
    "The values of k1 that were compared.",
}


@pytest.fixture(scope="module")
def verdicts():
    return {
        claim.statement: {
            name: judge(claim, evidence).verdict for name, evidence in RESULTS.items()
        }
        for claim in ALL
    }


@pytest.mark.slow("all claims in all invented worlds, once for all of these tests")
@pytest.mark.parametrize("claim", ALL, ids=lambda claim: claim.statement)
def test_every_check_can_fail_and_can_hold(verdicts, claim):
    words = set(verdicts[claim.statement].values())
    if claim.statement in NEVER_DECIDED:
        assert words == {Verdict.OPEN}
    else:
        assert {Verdict.AGREE, Verdict.DIFFER} <= words


def test_claims_and_report_load_no_kernel():
    """They judge what stands in archives."""
    program = "import sys, paper.claims, paper.report; sys.exit('numba' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", program], cwd=REPO, check=False).returncode == 0


def test_claims_name_place_figure_and_one_line():
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


def test_frequencies_off_the_grid_are_missing():
    system = System("none", {"m1": 1, "k1": 1, "c1": 1, "P": 1, "omega": 1})
    data = Data(system, {"omega": np.arange(3.0)}, {})
    with pytest.raises(Missing, match=r"0\.5 rad/s"):
        data.place(0.5)
    with pytest.raises(Missing, match="not recorded"):
        data.peak()


def test_maxima_and_spans():
    values = np.array([0, 5, 1, 10, 10, 0, 2, 1.0])
    np.testing.assert_array_equal(maxima(values, 0.3), [1, 3])
    assert spans(np.arange(5.0), np.array([1, 1, 0, 0, 1], bool)) == [(0, 1), (4, 4)]
    assert spans(np.arange(2.0), np.zeros(2, bool)) == []
