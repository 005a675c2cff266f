"""Slow sweeps jump where branches fold: the response in time beside continuation."""

import numpy as np
import pytest

import nlds_vines as nv
from nlds_vines.loads.picture import envelope

SYSTEM, P, PERIODS = "ssul-set5", 800.0, 20
RATES = 2e-4, 5e-5  # rad/s^2


@pytest.fixture(scope="module")
def branches(tmp_path_factory):
    """Return the branches of a damper along omega, with their archive."""
    path = tmp_path_factory.mktemp("branches") / "branches.h5"
    return nv.continue_branch(SYSTEM, "omega", (6.9, 7.4), to=path, quiet=True)


def swept(first, last, rate):
    """Return the response history of a sweep, of 32 states in each natural period."""
    length = abs(last - first) / rate
    sweep = {"amplitude": P, "first": first, "last": last, "length": length}
    return nv.response_history(
        SYSTEM, load={"sweep": sweep}, duration=length, sampling={"samples": 32}, quiet=True
    )


def jump(first, last, rate):
    """Return the frequency at which E1 changes most: its mean over periods on either side."""
    amplitudes = swept(first, last, rate)
    (sweep,), (fall,) = amplitudes.request.load.sweep, amplitudes.results.values()
    omega, energy = envelope(sweep, fall.time, fall.E1, 2 * np.pi / np.sqrt(40.0))
    means = np.convolve(energy, np.ones(PERIODS) / PERIODS, mode="valid")
    change = np.abs(means[PERIODS:] - means[:-PERIODS])
    places = omega[PERIODS : PERIODS + len(change)]
    inside = (places > 7.02) & (places < 7.27)
    return places[inside][change[inside].argmax()]


@pytest.mark.kernels
def test_a_slow_sweep_jumps_behind_the_fold_and_nearer_to_it_the_slower_it_is(branches):
    """The delay of a slow passage through a fold grows with its rate to the power 2/3."""
    folds = np.sort(branches.special_points.value[branches.special_points.kind == "LP"])
    upper, lower = folds[-1], folds[0]
    delays = [jump(6.95, 7.3, rate) - upper for rate in RATES]
    assert 0 < delays[1] < delays[0] < 0.02
    assert delays[0] / delays[1] == pytest.approx(4 ** (2 / 3), rel=0.06)
    exact = (4 ** (2 / 3) * delays[1] - delays[0]) / (4 ** (2 / 3) - 1)
    assert exact == pytest.approx(0, abs=4e-4)
    delays = [lower - jump(7.3, 6.95, rate) for rate in RATES]
    assert 0 < delays[1] < delays[0] < 0.01


@pytest.mark.kernels
def test_branches_are_drawn_beside_a_sweep(branches, tmp_path, refusal, ask):
    path, picture = tmp_path / "sweep.h5", tmp_path / "sweep.png"
    words = f"sweep:amplitude={P:g},first=7.0,last=7.3,length=60"
    asked = ["response-history", "--system", SYSTEM, "--load", words, "--duration", "60", "--quiet"]
    ask(*asked, "-o", path)
    figure = nv.plot(path, "sweep_energy", marks=branches.path)
    (axes,) = figure.axes
    branch = branches.branches[0]
    drawn = [line for line in axes.get_lines() if len(line.get_xdata()) == len(branch)]
    assert all(np.array_equal(line.get_xdata(), branch.parameter) for line in drawn)
    assert np.array_equal(drawn[0].get_ydata(), branch.E1max)
    assert np.array_equal(np.isfinite(drawn[1].get_ydata()), branch.stable)
    assert axes.get_xlim() == (7.0, 7.3)
    plot = ["plot", str(path), "--mark", str(branches.path), "-o", str(picture)]
    assert "--show sweep_energy" in refusal(*plot)
    other = ["--set", "P=700", "--along", "omega=7.2:7.3", "-o", str(tmp_path / "other.h5")]
    ask("continuation", "--system", SYSTEM, *other, "--quiet")
    plot[3] = str(tmp_path / "other.h5")
    assert "P = 700.0, not 800.0" in refusal(*plot, "--show", "sweep_energy")
    assert not picture.exists()
