"""Tori beside an NS: followed until they lock or break, and their rotation number."""

import numpy as np
import pytest

import nlds_vines as nv
from nlds_vines.__main__ import main

pytestmark = pytest.mark.kernels


@pytest.fixture(scope="module")
def result(tmp_path_factory):
    """Return the branches of Set 6 with the tori beside the NS of 2T,2."""
    path = tmp_path_factory.mktemp("tori") / "tori.h5"
    asked = "continuation --doublings 1 --along omega=7.3:7.5 --unstable 30 --tori 40 --quiet"
    assert main([*asked.split(), "-o", str(path)]) == 0
    return nv.open_archive(path)


def test_a_torus_is_followed_from_its_beginning_until_it_locks(result):
    first, second = result.tori
    rows = result.special_points
    assert rows.kind[[first.special, second.special]].tolist() == ["NS", "NS"]
    begin, end = rows.value[[first.special, second.special]]
    # on the side where the orbit is unstable, towards the other NS
    for torus, low, high in ((first, begin, end), (second, begin, end)):
        assert low < torus.values.min() < torus.values.max() < high
    distances = np.abs(first.values - begin)
    assert (np.diff(distances) > 0).all()
    assert first.labels[0] == "quasiperiodic"
    ends = [run for run in first.runs if run[0] not in ("quasiperiodic", "undetermined")]
    label, broken, _ = ends[0]
    assert label in ("chaos", "36T,36")
    assert 7.3701 < broken < 7.3703
    assert "36T,36" in first.labels  # beside the border
    # which is sharp to a thousandth of a cell
    before = first.values[first.values < broken].max()
    assert broken - before < 1.01e-3 * (end - begin) / 41
    # there is no torus at the second, which is subcritical
    assert second.labels[0] == "3T,2"
    lines = list(result.lines())
    of_torus = [line for line in lines if line.startswith("      ")]
    assert of_torus[0].startswith("      torus: quasiperiodic to 7.3701")
    assert of_torus[1] == "      no stable torus beside it, but 3T,2"


def test_labels_are_those_of_long_simulations(result):
    """On the torus a small section stays invariant and no period closes; where locked, 36T does."""
    first = result.tori[0]
    row = result.special_points[first.special]
    locked = first.values[first.labels == "36T,36"][0]
    for value, is_locked in ((first.values[0], False), (locked, True)):
        there = nv.load_system("ssul-set6", omega=value)
        orbit = nv.simulate(there, 4000 + 36, start=row.state * 1.001, tolerance="fine")
        gap = np.abs(orbit.section[-1] - orbit.section[-37]).max()
        nearest = np.abs(orbit.section[-1] - orbit.section[-2]).max()
        assert (gap < 1e-6 * nearest) == is_locked


def test_the_rotation_number_of_the_torus_is_near_that_of_its_beginning(result):
    """By the angles of sections around the unstable orbit; at the NS itself it is exact."""
    first = result.tori[0]
    row = result.special_points[first.special]
    value = float(row.value) + 2e-4
    there = nv.load_system("ssul-set6", omega=value)
    (center,) = [o for o in result.orbits_at(value) if o.period == 2 and not o.stable]
    orbit = nv.simulate(there, 6000, start=center.state * 1.001, tolerance="fine")
    returns = orbit.section[1::2][1500:] - center.state
    # principal axes make the closed curve nearly a circle
    _, _, axes = np.linalg.svd(returns - returns.mean(axis=0), full_matrices=False)
    x, y = returns @ axes[0], returns @ axes[1]
    angle = np.unwrap(np.arctan2(y / y.std(), x / x.std()))
    turns = abs(angle[-1] - angle[0]) / (2 * np.pi * (len(angle) - 1))
    assert turns == pytest.approx(row.rotation, abs=5e-3)


def test_without_tori_nothing_is_stored(tmp_path, refusal):
    result = nv.continue_branch("ssul-set6", "omega", (7.3, 7.31), step=0.2, quiet=True)
    assert result.tori == ()
    assert not any(name.startswith("torus") for name in result.tables)
    words = refusal("continuation", "--tori", "-1", "-o", tmp_path / "a.h5")
    assert "tori = -1 must be a whole number from 0 to 10000" in words
