"""For how long chaos was watched: in the summary, in legends, and as a bound of its lifetime."""

import numpy as np
import pytest

from nlds_vines.bifurcation.picture.choices import in_legend
from nlds_vines.bifurcation.run import Report
from nlds_vines.model.labels import least_lifetime
from nlds_vines.orbits.solver_settings import EFFORTS, most_watched


def test_a_scan_knows_how_long_it_watches():
    assert most_watched(600, 120, "quick") == 720
    assert most_watched(600, 120, "standard") == 720 + 3000
    assert most_watched(0, 1, "thorough") == 1 + sum(EFFORTS["thorough"])


def test_the_bound_is_that_of_the_exponential_law():
    """Chaos of that mean lifetime survives so long in one case of twenty."""
    least = least_lifetime(3720)
    assert np.exp(-3720 / least) == pytest.approx(0.05, rel=1e-12)
    lifetimes = np.random.default_rng(1).exponential(least, 200_000)
    assert (lifetimes > 3720).mean() == pytest.approx(0.05, abs=0.002)
    assert least_lifetime(3720, 0.5) > least


def test_only_of_chaos_the_summary_says_how_long_it_was_watched(tmp_path):
    report = Report(tmp_path / "a.h5", watched=3720)
    report.tally.labels.update(["T,1", "3T,2"])
    assert report.remarks() == []
    report.tally.labels.update(["chaos"])
    (line,) = report.remarks()
    assert "watched for 3720 periods" in line
    assert "1242 periods or more" in line


class Archive:
    """What a legend reads of an archive."""

    def request(self, content, load):
        assert content == "scan"
        return load(None, {"sampling": {"transient": 300, "effort": "thorough"}})


def test_only_chaos_has_a_time_in_a_legend():
    assert in_legend("chaos", Archive()) == f"chaos (for {300 + 120 + 51_000} T)"
    assert in_legend("3T,2", Archive()) == "3T,2"
    assert in_legend("chaos → T,0", Archive()) == "chaos → T,0"
