"""The cyclic chain of Weidemann et al. (2025): the page's closed forms beside orbits."""

from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

import nlds_vines as nv

pytestmark = pytest.mark.kernels

PAGE = Path(__file__).resolve().parents[2] / "docs" / "gallery" / "plot_24_localized_chain.py"


@pytest.fixture(scope="module")
def page():
    """What the page defines before its picture."""
    names = {}
    exec("".join(PAGE.read_text(encoding="utf-8").split("# %%")[:3]), names)
    return SimpleNamespace(**names)


@pytest.mark.parametrize("strikers", [(0,), (0, 5), (0, 2, 4, 6, 8), tuple(range(10))])
def test_an_exact_motion_returns_after_a_period(page, strikers):
    """It joins half periods of the chain's exponential, with up to ten walls struck at once."""
    for r in (0.987, 0.99):
        motions = list(page.exact(r, strikers))
        assert len(motions) == 2
        for _, start in motions:
            orbit = nv.simulate(page.system(r), 1, start=start.ravel(), quiet=True)
            assert np.abs(orbit.state - start.ravel()).max() < 2e-13 * page.gap
            names = {f"ball{i}" for i in strikers}
            assert len(orbit.impacts) == 2 * len(strikers)
            assert set(orbit.impacts["damper"].tolist()) == names


@pytest.mark.parametrize("strikers", [(0,), (0, 5), tuple(range(10))])
@pytest.mark.parametrize("r", [0.987, 0.989])
def test_orbits_settle_on_the_published_response(page, strikers, r):
    """Harmonic balance keeps one harmonic of the motion: 1.2 to 1.7 % in the clearance."""
    xi, start = max(page.exact(r, strikers), key=lambda motion: motion[0])
    amplitudes, rates = page.settled(r, 1.001 * start, transient=1500)
    assert np.array_equal(np.flatnonzero(rates == 2), strikers)
    assert rates.sum() == 2 * len(strikers)
    assert amplitudes[0] == pytest.approx(xi, rel=2e-3)
    assert 1.012 < page.published(amplitudes[0], r, strikers) / page.GAMMA < 1.017


def patterns(N):
    """Return the patterns of strikers in a ring of N, one of each set of rotations."""
    every = [tuple((i >> j) & 1 for j in range(N)) for i in range(1, 2**N - 1)]
    return {max(bits[j:] + bits[:j] for j in range(N)) for bits in every}


def neighbors(pattern):
    """Return how many oscillators in a row strike at most."""
    return max(map(len, "".join(map(str, pattern * 2)).split("0")))


def lasts(page, pattern):
    r = 0.993297
    _, start = max(page.exact(r), key=lambda motion: motion[0])
    chosen = np.where(pattern, 0, 5)
    rates = page.settled(r, start[np.concatenate([chosen, 10 + chosen])], transient=600)[1]
    return np.array_equal(rates, 2 * np.array(pattern))


def test_a_ring_of_ten_has_106_patterns(page):
    """The formula is published: sum of 2^gcd(i, N) over N, less the two uniform ones."""
    N = page.N
    assert len(patterns(N)) == sum(2 ** np.gcd(i, N) for i in range(1, N + 1)) // N - 2 == 106


@pytest.mark.parametrize(
    ("pattern", "is_stable"),
    [((1, 1, 0, 1, 1, 0, 1, 0, 0, 0), True), ((1, 1, 1, 0, 0, 1, 0, 0, 0, 0), False)],
)
def test_three_strikers_in_a_row_do_not_last(page, pattern, is_stable):
    assert lasts(page, pattern) == is_stable


@pytest.mark.long
def test_all_patterns_without_three_in_a_row_last(page):
    lasting = {pattern for pattern in patterns(page.N) if lasts(page, pattern)}
    assert lasting == {pattern for pattern in patterns(page.N) if neighbors(pattern) <= 2}
    assert len(lasting) == 47
