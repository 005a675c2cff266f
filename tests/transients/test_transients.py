"""Ensembles: lifetimes, shares and basins from arrays and archives, the command, its picture."""

import numpy as np
import pytest
from layout import collisions

import nlds_vines as nv
from nlds_vines.bifurcation.run import Computer
from nlds_vines.engine.records import DIVERGED
from nlds_vines.transients.basins import basin_entropy, uncertainty_exponent
from nlds_vines.transients.ensemble import Ensemble, decay, ensemble_of, share_interval, survival
from nlds_vines.transients.picture import draw_ensemble
from scans import scan_of

LATE = "transient chaos to T,0"
LABELS = np.array(["T,0", LATE, LATE, "chaos", "2T,1", "quasiperiodic", "failed"], dtype=object)
SETTLING = np.array([4, 90, 210, -1, 12, -1, -1])
WATCHED = np.array([300.0, 300.0, 300.0, 900.0, 300.0, 3300.0, np.nan])
SMALL = {"starts": 40, "transient": 200, "periods": 40, "effort": "quick"}
SADDLE = {"omega": 7.575, "K": 2.5e7}
OPTIONS = ["--set", "omega=7.575", "--set", "K=2.5e7", "--starts", "40", "--transient", "200"]
OPTIONS += ["--periods", "40", "--effort", "quick"]


def ensemble(*rows):
    """Return the ensemble of all orbits, or of those from one row to another."""
    part = slice(*rows) if rows else slice(None)
    return Ensemble(LABELS[part], SETTLING[part], WATCHED[part], delay=50.0)


def test_lifetimes_shares_and_words_of_an_ensemble():
    # what has a lifetime counts, and what was watched is censored
    lifetimes = ensemble()
    assert lifetimes.times.tolist() == [4, 90, 210, 900, 12]
    assert lifetimes.ended.tolist() == [True, True, True, False, True]
    np.testing.assert_allclose(lifetimes.survival.share, [0.8, 0.6, 0.4, 0.2])
    assert (lifetimes.decay.ended, lifetimes.decay.exposure) == (2, 40 + 160 + 850)
    # shares are those of final regimes
    shares = {entry.label: entry for entry in ensemble().shares}
    assert (shares["T,0"].count, shares["T,0"].through_chaos) == (3, 2)
    assert shares["T,0"].share == pytest.approx(3 / 7)
    assert shares["T,0"].low < 3 / 7 < shares["T,0"].high
    assert shares["2T,1"].through_chaos == 0
    assert sum(entry.count for entry in shares.values()) == 7
    # all is told in words
    text = "\n".join(ensemble().lines())
    for words in (
        *("T,0                 3   42.86%", "2 through chaos", "settled: 4 of 5"),
        *("watched for 900 to 900", "half by 90", "99% not yet", "beyond 50 periods"),
    ):
        assert words in text
    # also that there are none, or none beyond the delay
    for rows, words in (
        ((5, None), "lifetimes: none"), ((0, 1), "no law of decay"), ((3, 4), "or more"),
    ):  # fmt: skip
        assert words in "\n".join(ensemble(*rows).lines())
    assert ensemble(0, 1).decay is None


def test_a_picture_shows_curve_law_censoring_and_shares_or_shares_alone():
    figure = draw_ensemble(ensemble(), "a test")
    curve, bars = figure.axes
    assert curve.get_yscale() == "log"
    labels = [text.get_text() for text in curve.get_legend().get_texts()]
    assert [text.split()[0] for text in labels] == ["not", "its", "no", r"$\exp(-t/\tau)$,"]
    step = curve.get_lines()[0]
    np.testing.assert_allclose(step.get_ydata(), [1, 0.8, 0.6, 0.4, 0.2, 0.2])
    assert bars.get_yticklabels()[0].get_text() == "T,0"
    assert bars.texts[0].get_text() == "3, 2 through chaos"
    assert collisions(figure) == []
    # without lifetimes only the shares are drawn
    (bars,) = draw_ensemble(ensemble(5, None), "a test").axes
    assert bars.get_xlabel().startswith("share of the starts")


@pytest.mark.kernels
def test_the_command_stores_tells_and_draws(here, answer):
    text = answer("transients", *OPTIONS, "-o", "a.h5")
    assert "K = 2.5e+07 N/m^1.5: 40 starts" in text
    assert text.endswith("a.h5\na.png\n")
    with nv.read("a.h5") as archive:
        stored = ensemble_of(archive, delay=50.0)
        settled = archive["settling"].ravel() >= 0
    assert stored.labels.size == 40
    np.testing.assert_array_equal(stored.ended, settled)
    assert (stored.times[~stored.ended] == 240).all()  # all that was watched, without a stage
    assert 0 < stored.ended.sum() < 40
    assert stored.decay.low < 1 / 180 < stored.decay.high  # of 1000 starts watched to the end


@pytest.mark.kernels
def test_an_archive_is_looked_at_again_and_more_starts_begin_with_the_same_ones(here, error_of):
    system = nv.load_system("ssul-set6", **SADDLE)
    first = nv.transient_lifetimes(system, to="a.h5", delay=0.0, **SMALL)
    before = (here / "a.h5").read_bytes()
    again = nv.transient_lifetimes(system, to="a.h5", delay=100.0, resume=True, **SMALL)
    assert (here / "a.h5").read_bytes() == before
    np.testing.assert_array_equal(first.times, again.times)
    assert again.decay.ended < first.decay.ended
    assert "overwrite=True" in error_of(nv.transient_lifetimes, system, to="a.h5", **SMALL)
    few = nv.transient_lifetimes(system, to="few.h5", **{**SMALL, "starts": 15})
    other = nv.transient_lifetimes(system, to="other.h5", seed=1, **SMALL)
    np.testing.assert_array_equal(few.settling, first.settling[:15])
    assert not np.array_equal(first.settling, other.settling)
    # an archive without verdicts is refused
    scan = scan_of("ssul-set6", ["lyapunov"], {"omega": [7.4]}, transient=5, periods=5)
    with nv.scan(scan, quiet=True).read() as archive:
        assert "label, settling, watched" in error_of(ensemble_of, archive)


@pytest.mark.kernels
def test_failed_orbits_are_told_by_the_status(here, ask, monkeypatch):
    block = Computer.block

    def two_failed(*arguments):
        arrays = block(*arguments)
        if arguments[1].index == 0:
            arrays["status"][0, :2], arrays["label"][0, :2] = DIVERGED, "failed"
        return arrays

    monkeypatch.setattr(Computer, "block", two_failed)
    error = ask("transients", *OPTIONS, "--quiet", status=1).err
    assert "2 of 40 orbits failed: 2 diverged (Check masses" in error


WEEKS = (6, 6, 6, 6, 7, 9, 10, 10, 11, 13, 16, 17, 19, 20, 22, 23, 25, 32, 32, 34, 35)
RELAPSED = (1, 1, 1, 0, 1, 0, 1, 0, 0, 1, 1, 0, 0, 0, 1, 1, 0, 0, 0, 0, 0)
"""Remissions under 6-MP, Freireich and others (1963): the example of every textbook."""


def test_the_textbook_example_with_greenwoods_interval():
    curve = survival(WEEKS, RELAPSED)
    assert curve.times.tolist() == [6, 7, 10, 13, 16, 22, 23]
    printed = [0.8571, 0.8067, 0.7529, 0.6902, 0.6275, 0.5378, 0.4482]
    np.testing.assert_allclose(curve.share, printed, atol=5e-5)
    assert curve.quantile(0.5) == 23
    assert np.isnan(curve.quantile(0.9))
    # the interval is that of log minus log with Greenwood's variance
    curve = survival(WEEKS, RELAPSED, level=0.95)
    at_risk, ended = np.array([21, 17, 15, 12, 11, 7, 6]), np.array([3, 1, 1, 1, 1, 1, 1])
    terms = ended / (at_risk * (at_risk - ended))
    width = 1.959964 * np.sqrt(np.cumsum(terms)) / np.abs(np.log(curve.share))
    np.testing.assert_allclose(curve.low, curve.share ** np.exp(width), rtol=1e-6)
    np.testing.assert_allclose(curve.high, curve.share ** np.exp(-width), rtol=1e-6)


def test_without_censoring_it_is_the_share_that_is_left():
    times = np.array([3.0, 1.0, 2.0, 2.0, 5.0])
    curve = survival(times, np.ones(5, dtype=bool))
    np.testing.assert_allclose(curve.share, [0.8, 0.4, 0.2, 0.0], atol=1e-15)
    assert [curve.quantile(q) for q in (0.2, 0.5, 1.0)] == [1.0, 2.0, 5.0]
    # what ends and what is last watched at one time
    curve = survival([2.0, 2.0, 3.0], [True, False, True])
    np.testing.assert_allclose(curve.share, [2 / 3, 0.0], atol=1e-15)
    # nothing that ended leaves everything
    curve = survival([4.0, 7.0], [False, False])
    assert curve.times.size == curve.low.size == 0
    assert np.isnan(curve.quantile(0.1))
    law = decay([4.0, 7.0], [False, False])
    assert (law.rate, law.low, law.ended, law.mean) == (0.0, 0.0, 0, np.inf)
    assert law.high == pytest.approx(-np.log(0.025) / 11)


def test_the_rate_is_deaths_over_exposure_beyond_the_delay_and_shares_have_wilsons_interval():
    law = decay([1.0, 4.0, 6.0, 10.0], [True, True, True, False], delay=3.0)
    assert (law.ended, law.exposure) == (2, 11.0)
    assert law.rate == pytest.approx(2 / 11)
    # of a Poisson count of 2, textbook: 0.2422 to 7.2247
    assert (11 * law.low, 11 * law.high) == pytest.approx((0.2422, 7.2247), abs=1e-4)
    # Wilson's interval
    # Newcombe (1998), table I
    assert share_interval(81, 263) == pytest.approx((0.2553, 0.3662), abs=1e-4)
    assert share_interval(0, 20) == pytest.approx((0.0, 0.1611), abs=1e-4)


@pytest.mark.parametrize("watched", [50.0, 200.0, 2000.0])
def test_a_known_rate_is_recovered_and_covered(watched):
    generator, covered, rates = np.random.default_rng(7), 0, []
    for _ in range(400):
        times = generator.exponential(100.0, 80) + 20.0
        law = decay(np.minimum(times, watched), times <= watched, delay=20.0)
        rates.append(law.rate)
        covered += law.low <= 0.01 <= law.high
    assert np.mean(rates) == pytest.approx(0.01, rel=0.05)
    assert 0.93 <= covered / 400 <= 0.995


def test_the_curve_covers_a_known_one():
    generator, covered = np.random.default_rng(8), 0
    for _ in range(300):
        times = generator.exponential(100.0, 80)
        watched = generator.uniform(50.0, 300.0, 80)
        curve = survival(np.minimum(times, watched), times <= watched)
        place = np.searchsorted(curve.times, 60.0) - 1
        covered += curve.low[place] <= np.exp(-0.6) <= curve.high[place]
    assert 0.92 <= covered / 300 <= 0.98


@pytest.mark.parametrize(
    ("times", "ended", "message"),
    [
        ([], [], "no lifetimes"),
        ([1.0], [True, False], "as many"),
        ([-1.0], [True], "0 or more"),
        ([np.nan], [True], "finite"),
    ],
)
def test_what_is_no_lifetime_is_refused(times, ended, message, error_of):
    for estimate in (survival, decay):
        assert message in error_of(estimate, times, ended)
    assert "delay = 9" in error_of(decay, [1.0, 9.0], [True, True], delay=9.0)
    assert "as many" in error_of(Ensemble, LABELS, SETTLING[:2], WATCHED)


def half_planes(size, slope=0.37, place=0.6):
    x, y = np.meshgrid(np.arange(size), np.arange(size))
    return (x + slope * y > place * size).astype(np.int64)


def tent_basins(size, lines):
    """Whether a start leaves [0, 1] after an even number of steps of x -> 3 min(x, 1 - x).

    The boundary is the middle-third Cantor set, of dimension ln 2 / ln 3 (Ott, Chaos in Dynamical
    Systems, 2nd ed., section 3.1), so that the exponent is 1 - ln 2 / ln 3.
    """
    x = (np.arange(size) + 0.5) / size
    steps, inside = np.zeros(size, np.int64), np.ones(size, bool)
    for step in range(40):
        x = np.where(inside, 3 * np.minimum(x, 1 - x), x)
        steps[inside & (x > 1)] = step
        inside &= x <= 1
    return np.broadcast_to((steps % 2)[:, np.newaxis], (size, lines))


def newton_basins(size, roots):
    """The roots of z^n = 1 that Newton's method finds: n basins with one common boundary."""
    x = np.linspace(-1.5, 1.5, size)
    z = x[np.newaxis, :] + 1j * x[:, np.newaxis] + 1e-9
    for _ in range(200):
        z = z - (z**roots - 1) / (roots * z ** (roots - 1))
    roots = np.exp(2j * np.pi * np.arange(roots) / roots)
    return np.argmin(np.abs(z[..., np.newaxis] - roots), axis=-1)


def test_exponents_and_entropies_of_straight_and_fractal_boundaries():
    # a straight boundary has exponent one
    exponent = uncertainty_exponent(half_planes(800))
    assert exponent.exponent == pytest.approx(1.0, abs=0.005)
    assert abs(exponent.exponent - 1.0) < 3 * exponent.error
    assert exponent.distances.tolist() == [1, 2, 4, 8, 16, 32, 64]
    # of the pairs in rows as many differ as the boundary is wide, in columns 0.37 of these at most
    assert exponent.shares[3] == pytest.approx(8 * exponent.shares[0], rel=0.01)
    # a fractal one has the exponent of its dimension
    exponent = uncertainty_exponent(tent_basins(3**8, 2056))
    expected = 1 - np.log(2) / np.log(3)
    assert exponent.exponent == pytest.approx(expected, abs=0.02)
    assert abs(exponent.exponent - expected) < 3 * exponent.error < 0.05
    # the entropy of a straight one is below ln 2
    plane = np.zeros((400, 400), np.int64)
    plane[:, 190:] = 7  # parts the boxes of the tenth column of boxes in halves
    entropy = basin_entropy(plane)
    assert (entropy.boxes, entropy.boundary_boxes) == (400, 20)
    assert entropy.boundary == pytest.approx(np.log(2))
    assert entropy.basin == pytest.approx(np.log(2) / 20)
    slanted = basin_entropy(half_planes(800))
    assert 0.3 < slanted.boundary < np.log(2)
    assert not slanted.fractal
    # one of eight basins at once is seen to be fractal
    plane = newton_basins(600, roots=8)
    assert basin_entropy(plane).boundary > np.log(2)
    assert basin_entropy(plane).fractal
    assert 0.0 < uncertainty_exponent(plane).exponent < 0.9


def test_riddled_basins_one_basin_and_unknown_cells():
    plane = np.random.default_rng(5).integers(0, 3, (600, 600))
    assert uncertainty_exponent(plane).exponent == pytest.approx(0.0, abs=0.001)
    entropy = basin_entropy(plane)
    # 400 draws from three: ln 3, less (3 - 1) / (2 * 400) for so few draws
    assert entropy.basin == entropy.boundary == pytest.approx(np.log(3) - 1 / 400, abs=2e-4)
    assert entropy.fractal
    # one basin has no boundary
    plane = np.zeros((64, 64), np.int64)
    assert np.isnan(basin_entropy(plane).boundary)
    assert basin_entropy(plane).basin == 0.0
    assert np.isnan(uncertainty_exponent(plane).exponent)
    # unknown cells count nowhere
    plane = half_planes(400)
    holes = plane.copy()
    holes[np.random.default_rng(1).random(plane.shape) < 0.3] = -1
    assert basin_entropy(holes).boundary == pytest.approx(basin_entropy(plane).boundary, rel=0.05)
    assert uncertainty_exponent(holes).exponent == pytest.approx(1.0, abs=0.02)
    assert np.isnan(basin_entropy(np.full((40, 40), -1)).basin)
