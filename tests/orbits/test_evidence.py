"""From rows of evidence to datasets and words: made-up rows of which everything is known."""

import numpy as np
import pytest

from nlds_vines.kernels.scene import codes as ev
from nlds_vines.kernels.scene.codes import DIVERGED, OK
from nlds_vines.model.labels import FLAGS, flags_of, label_of, labels_of
from nlds_vines.model.system import CELL
from nlds_vines.orbits.batch import verdict_arrays

OMEGA, REST, N = 6.28, 0.3, 2
T = 2 * np.pi / OMEGA
DIAGONAL = [-0.1, 0.8, 0.2, -0.4]


def rows_of(*columns):
    """Return rows of evidence (lanes, 1, COLUMNS) with these columns, NaN elsewhere."""
    rows = np.full((len(columns), 1, ev.LENGTH_OF_ROW), np.nan)
    for row, values in zip(rows[:, 0], columns, strict=True):
        row[ev.KIND], row[ev.CYCLE_PERIOD], row[ev.SETTLING] = 0.0, 0.0, -1.0
        for place, value in values.items():
            row[place : place + np.size(value)] = value
    return rows


PERIODIC = {
    ev.KIND: FLAGS["periodic"],
    ev.CYCLE_PERIOD: N,
    ev.NEAR_IMPACTS: 3,
    ev.FAR_IMPACTS: 1,
    ev.SETTLING: 17,
    ev.MONODROMY: np.diag(DIAGONAL).ravel(),
    ev.POINT: [0.01, 0.2, 0.05, -0.6],
}
CHAOTIC = {ev.KIND: FLAGS["chaotic"], ev.EXPONENTS: [0.3, 0.0, -0.7, -1.0]}


@pytest.fixture
def judged():
    """Return the datasets of a 2T,4 orbit, of chaos, and of a lane that failed."""
    cells = np.zeros((3, 1), CELL)
    cells["omega"], cells["rest"] = OMEGA, REST
    status = np.array([[OK], [OK], [DIVERGED]])
    counts = np.array([[[7, 8]], [[5, 6]], [[1, 1]]])
    arrays = verdict_arrays(status, rows_of(PERIODIC, CHAOTIC, PERIODIC), counts, cells, 4)
    return {name: values[:, 0] for name, values in arrays.items()}


def test_labels_count_impacts_of_a_cycle_or_of_the_window(judged):
    assert judged["label"].tolist() == ["2T,4", "chaos", "failed"]
    assert judged["impacts_by_wall"].tolist()[:2] == [[3, 1], [5, 6]]
    assert judged["impact_count"].tolist()[:2] == [4, 11]
    assert judged["regime"].tolist() == [FLAGS[n] for n in ("periodic", "chaotic", "failed")]
    assert judged["settling"].tolist() == [17, -1, -1]


def test_multipliers_come_by_their_moduli(judged):
    np.testing.assert_allclose(judged["multipliers"][0, :, 0], [0.8, -0.4, 0.2, -0.1])
    np.testing.assert_array_equal(judged["multipliers"][0, :, 1], 0.0)
    assert np.isnan(judged["multipliers"][1:]).all()


def test_exponents_of_a_cycle_are_those_of_its_multipliers(judged):
    expected = np.log([0.8, 0.4, 0.2, 0.1]) / (N * T)
    np.testing.assert_allclose(judged["exponents"][0], expected)
    np.testing.assert_array_equal(judged["exponents"][1], [0.3, 0.0, -0.7, -1.0])


def test_points_are_in_the_users_coordinates(judged):
    np.testing.assert_allclose(judged["orbit_point"][0], [0.01, 0.2, 0.01 - 0.05 + REST, 0.8])
    assert np.isnan(judged["orbit_point"][1]).all()


def test_a_lane_that_failed_keeps_no_evidence(judged):
    assert judged["periodicity"][2] == 0
    for name in ("exponents", "multipliers", "orbit_point", "lyapunov", "residual"):
        assert np.isnan(judged[name][2]).all(), name


def test_words_of_every_kind():
    regime = np.array([FLAGS[n] for n in ("periodic", "transient_chaos", "chaotic", "failed")])
    period, impacts = np.array([3, 1, 0, 0]), np.array([2, 0, 9, 0])
    expected = ["3T,2", "transient chaos to T,0", "chaos", "failed"]
    assert labels_of(regime, period, impacts).tolist() == expected
    assert [label_of(*one) for one in zip(regime, period, impacts, strict=True)] == expected
    kinds = np.array([1, 3, 1])
    assert flags_of(np.array([OK, OK, DIVERGED]), kinds).tolist() == [1, 3, FLAGS["failed"]]
