"""Ensembles: lifetimes and shares from arrays and archives, the command, its picture.

All orbits here record the same of the same scene, so that one compilation serves them all.
"""

import numpy as np
import pytest

import nlds_vines as nv
from nlds_vines.bifurcation import run as scan_run
from nlds_vines.bifurcation.run import Computer
from nlds_vines.errors import RequestError
from nlds_vines.orbits.records import DIVERGED
from nlds_vines.runs.interrupts import Interrupted
from nlds_vines.transients.ensemble import Ensemble, ensemble_of
from nlds_vines.transients.picture import draw_ensemble

LATE = "transient chaos to T,0"
LABELS = np.array(["T,0", LATE, LATE, "chaos", "2T,1", "quasiperiodic", "failed"], dtype=object)
SETTLING = np.array([4, 90, 210, -1, 12, -1, -1])
WATCHED = np.array([300.0, 300.0, 300.0, 900.0, 300.0, 3300.0, np.nan])
SMALL = {"starts": 40, "transient": 200, "periods": 40, "effort": "quick"}
SADDLE = {"omega": 7.575, "K": 2.5e7}
OPTIONS = ["--set", "omega=7.575", "--set", "K=2.5e7", "--starts", "40", "--transient", "200"]
OPTIONS += ["--periods", "40", "--effort", "quick"]


def ensemble(delay=50.0):
    return Ensemble(LABELS, SETTLING, WATCHED, delay)


def test_what_has_a_lifetime_counts_and_what_was_watched_is_censored():
    lifetimes = ensemble()
    assert lifetimes.times.tolist() == [4, 90, 210, 900, 12]
    assert lifetimes.ended.tolist() == [True, True, True, False, True]
    np.testing.assert_allclose(lifetimes.survival.share, [0.8, 0.6, 0.4, 0.2])
    assert (lifetimes.decay.ended, lifetimes.decay.exposure) == (2, 40 + 160 + 850)


def test_shares_are_those_of_final_regimes():
    shares = {entry.label: entry for entry in ensemble().shares}
    assert (shares["T,0"].count, shares["T,0"].through_chaos) == (3, 2)
    assert shares["T,0"].share == pytest.approx(3 / 7)
    assert shares["T,0"].low < 3 / 7 < shares["T,0"].high
    assert shares["2T,1"].through_chaos == 0
    assert sum(entry.count for entry in shares.values()) == 7


def test_it_is_told_in_words():
    text = "\n".join(ensemble().lines())
    for words in (
        *("T,0                 3   42.86%", "2 through chaos", "settled: 4 of 5"),
        *("watched for 900 to 900", "half by 90", "99% not yet", "beyond 50 periods"),
    ):
        assert words in text


def test_no_lifetimes_and_none_beyond_the_delay_are_told_too():
    none = Ensemble(LABELS[5:], SETTLING[5:], WATCHED[5:])
    assert "lifetimes: none" in "\n".join(none.lines())
    early = Ensemble(LABELS[:1], SETTLING[:1], WATCHED[:1], delay=50.0)
    assert early.decay is None
    assert "no law of decay" in "\n".join(early.lines())
    open_end = Ensemble(LABELS[3:4], SETTLING[3:4], WATCHED[3:4], delay=50.0)
    assert "or more" in "\n".join(open_end.lines())


def test_arrays_that_do_not_belong_together_are_refused():
    with pytest.raises(RequestError, match="as many"):
        Ensemble(LABELS, SETTLING[:2], WATCHED)


# ---- pictures ------------------------------------------------------------------------------------


def test_the_picture_shows_curve_law_censoring_and_shares():
    figure = draw_ensemble(ensemble(), "a test")
    curve, bars = figure.axes
    assert curve.get_yscale() == "log"
    labels = [text.get_text() for text in curve.get_legend().get_texts()]
    assert [text.split()[0] for text in labels] == ["not", "its", "no", r"$\exp(-t/\tau)$,"]
    step = curve.get_lines()[0]
    np.testing.assert_allclose(step.get_ydata(), [1, 0.8, 0.6, 0.4, 0.2, 0.2])
    assert bars.get_yticklabels()[0].get_text() == "T,0"
    assert bars.texts[0].get_text() == "3, 2 through chaos"
    figure.draw_without_rendering()
    for axes in figure.axes:
        box = axes.get_tightbbox()
        assert box.x0 >= 0
        assert box.x1 <= figure.bbox.x1
        assert box.y0 >= 0


def test_without_lifetimes_only_the_shares_are_drawn():
    figure = draw_ensemble(Ensemble(LABELS[5:], SETTLING[5:], WATCHED[5:]), "a test")
    (bars,) = figure.axes
    assert bars.get_xlabel().startswith("share of the starts")


# ---- the command ---------------------------------------------------------------------------------


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
def test_the_same_archive_is_looked_at_again(here):
    system = nv.load_system("ssul-set6", **SADDLE)
    first = nv.transient_lifetimes(system, to="a.h5", delay=0.0, **SMALL)
    before = (here / "a.h5").read_bytes()
    again = nv.transient_lifetimes(system, to="a.h5", delay=100.0, resume=True, **SMALL)
    assert (here / "a.h5").read_bytes() == before
    np.testing.assert_array_equal(first.times, again.times)
    assert again.decay.ended < first.decay.ended
    with pytest.raises(RequestError, match="--overwrite"):
        nv.transient_lifetimes(system, to="a.h5", **SMALL)


@pytest.mark.kernels
def test_more_starts_of_a_seed_begin_with_the_same_ones(here):
    system = nv.load_system("ssul-set6", **SADDLE)
    few = nv.transient_lifetimes(system, to="few.h5", **{**SMALL, "starts": 15})
    many = nv.transient_lifetimes(system, to="many.h5", **SMALL)
    other = nv.transient_lifetimes(system, to="other.h5", seed=1, **SMALL)
    np.testing.assert_array_equal(few.settling, many.settling[:15])
    assert not np.array_equal(many.settling, other.settling)


@pytest.mark.kernels
def test_an_archive_without_verdicts_is_refused(here):
    scan = {
        "system": "ssul-set6",
        "vary": {"omega": {"values": [7.4]}},
        "sampling": {"transient": 5, "periods": 5},
        "record": {"want": ["lyapunov"]},
    }
    nv.scan(scan, to="x.h5")
    with nv.read("x.h5") as archive, pytest.raises(RequestError, match="label, settling, watched"):
        ensemble_of(archive)


def test_an_interrupted_ensemble_says_how_to_go_on(here, ask, monkeypatch):
    def stop(*_, **__):
        raise Interrupted("interrupted: --resume goes on from there")

    monkeypatch.setattr(scan_run, "run", stop)
    out, err = ask("transients", *OPTIONS, "--quiet", status=130)
    assert (out, err.count("\n")) == ("", 1)
    assert "--resume" in err
    assert list(here.iterdir()) == []


@pytest.mark.kernels
def test_failed_orbits_are_told_by_the_status(here, ask, monkeypatch):
    block = Computer.block

    def two_failed(*arguments):
        arrays = block(*arguments)
        if arguments[1].index == 0:
            arrays["status"][0, :2], arrays["label"][0, :2] = DIVERGED, "failed"
        return arrays

    monkeypatch.setattr(Computer, "block", two_failed)
    assert (
        "2 of 40 orbits failed: 2 diverged (Check masses"
        in ask("transients", *OPTIONS, "--quiet", status=1).err
    )
