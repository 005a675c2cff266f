"""Attractors: ends are grouped and matched on maps that are known; requests for them."""

from dataclasses import replace

import numpy as np
import pytest
from planes import ALONG, PLANE

import nlds_vines as nv
from nlds_vines.bifurcation import attractors
from nlds_vines.bifurcation.run import Computer
from nlds_vines.model.labels import finals

TURN = 2 * np.pi * 0.6180339887498949


def turning(states, periods):
    """Follow points on circles of any radius, a golden part of a turn at a time."""
    angles = TURN * np.arange(1, periods + 1)[:, np.newaxis]
    x, v = states[:, :1, np.newaxis], states[:, 1:2, np.newaxis]
    cos, sin = np.cos(angles)[np.newaxis], np.sin(angles)[np.newaxis]
    zero = 0.0 * x * cos
    return np.concatenate([x * cos - v * sin, x * sin + v * cos, zero, zero], axis=2)


def cycling(states, periods):
    """Follow cycles whose points have the same x and the velocities 1, 2, ... in turn."""
    sections = np.repeat(states[:, np.newaxis], periods, axis=1)
    sections[..., 1] = (states[:, 1:2] + np.arange(1, periods + 1)) % periods
    return sections


def ends_of(*kinds):
    """Labels and states of ends, each kind (label, x, v, how many), with round-off."""
    noise = np.random.default_rng(1)
    labels = [label for label, _, _, count in kinds for _ in range(count)]
    states = [[x, v, 0.0, 0.0] for _, x, v, count in kinds for _ in range(count)]
    return np.array(labels, object), np.array(states) * (1 + 1e-11 * noise.random((len(labels), 1)))


def groups_of(labels, states, order, sections=cycling):
    system = attractors.SystemAttractors(sections, np.ones(2))
    system.add(labels[order], states[order], order)
    return {frozenset(attractor.lanes.tolist()) for attractor in system.attractors}, system


def test_labels_say_what_is_periodic_and_a_sample_is_judged_where_it_is_less_than_half():
    assert attractors.sample_size(nv.load_scan(PLANE)) == 200
    assert attractors.sample_size(nv.load_scan(ALONG)) == 0  # half of its 30 starts
    labels = ("T,0", "3T,12", "chaos", "quasiperiodic", "undetermined", "failed", "")
    assert [attractors.period_of(label) for label in labels] == [1, 3, 0, 0, -1, -1, -1]
    assert [attractors.impacts_of(label) for label in labels[:3]] == [0, 12, -1]


def test_groups_do_not_depend_on_the_order_of_starts_and_have_margins():
    labels, states = ends_of(
        ("T,1", 0.3, 0.0, 5), ("T,1", -0.3, 0.0, 4), ("2T,1", 0.3, 0.0, 3), ("2T,1", 0.3, 1.0, 2),
        ("T,1", 0.3 + 1e-4, 0.0, 1), ("undetermined", 0.3, 0.0, 2), ("T,2", 0.3, 0.0, 1),
    )  # fmt: skip
    # both points of 2T,1 are one orbit; T,2 grazes on T,1; what is undetermined is on none
    expected = {(0, 1, 2, 3, 4, 17), (5, 6, 7, 8), (9, 10, 11, 12, 13), (14,)}
    for seed in range(5):
        order = np.random.default_rng(seed).permutation(len(labels))
        groups, system = groups_of(labels, states, order)
        assert groups == {frozenset(group) for group in expected}
        margins = sorted(attractor.margin for attractor in system.attractors)
        assert margins[:2] == pytest.approx([1e-4 / attractors.SAME] * 2, rel=1e-3)
    # the margin says how near an end is to being divided
    labels, states = ends_of(("T,1", 0.3, 0.0, 2))
    states[1, 0] = 0.3 + 0.25 * attractors.SAME
    (attractor,) = groups_of(labels, states, np.arange(2))[1].attractors
    assert attractor.margin == pytest.approx(4.0, rel=1e-3)
    # chaos and quasiperiodic motion are never one
    labels = np.array(["chaos", "quasiperiodic"], object)
    assert len(groups_of(labels, np.array([[1.0, 0, 0, 0]] * 2), np.arange(2), turning)[0]) == 2


@pytest.mark.parametrize("count", [8, 60])
def test_two_tori_are_two_attractors(count):
    """More orbits than are compared in pairs, too; the rare one is found wherever it stands."""
    angles = np.random.default_rng(2).uniform(0, 2 * np.pi, count)
    radii = np.where(np.arange(count) == count // 2 + 1, 0.8, 1.0)
    zero = np.zeros(count)
    states = np.stack([radii * np.cos(angles), radii * np.sin(angles), zero, zero], axis=1)
    labels = np.full(count, "quasiperiodic", object)
    for seed in range(2):
        order = np.random.default_rng(seed).permutation(count)
        groups, system = groups_of(labels, states, order, turning)
        assert sorted(map(len, groups)) == [1, count - 1]
        assert all(1.0 < attractor.margin < 1e3 for attractor in system.attractors)


def arcs(states, periods):
    """Follow orbits that fill a part v of the circle: slow chaos is seen on a part of it."""
    angles = TURN * np.arange(1, periods + 1) % (2 * np.pi) * states[:, 1:2]
    return np.stack([np.cos(angles), np.sin(angles), 0 * angles, 0 * angles], axis=2)


def test_an_orbit_that_shows_a_part_of_an_attractor_belongs_to_it(monkeypatch):
    monkeypatch.setattr(attractors, "PAIRS", 1)
    states = np.array([[1.0, 0.1, 0.0, 0.0], [1.0, 1.0, 0.0, 0.0]])
    for order in ([0, 1], [1, 0]):
        groups, _ = groups_of(np.full(2, "chaos", object), states, np.array(order), arcs)
        assert groups == {frozenset({0, 1})}


def at(x, *lanes, label="T,1"):
    points = np.array([[x, 0.0, 0.0, 0.0]])
    return attractors.Attractor(
        label, 1, points, points[0], np.array(lanes, int), np.ones(2), attractors.SAME
    )


def table_of(*systems, shape=None):
    numbering = attractors.Numbering(shape or (len(systems),))
    for group in systems:
        numbering.give(group)
    return [{k: one.points[0, 0] for k, one in row.items()} for row in numbering.table]


def test_matches_are_the_cheapest_and_none_is_farther_than_half_the_distance_of_the_next():
    assert attractors.matched({0: at(0.0), 1: at(0.2)}, [at(0.22), at(0.05)]) == {0: 1, 1: 0}
    # a step beyond half the distance of the next is none
    assert attractors.matched({0: at(0.0)}, [at(0.1), at(0.15)]) == {}
    assert attractors.matched({0: at(0.0)}, [at(0.1), at(0.25)]) == {0: 0}
    assert attractors.matched({0: at(0.0)}, [at(0.31)]) == {}
    assert attractors.matched({}, [at(0.0)]) == {}


def test_numbers_follow_attractors_are_remembered_and_come_with_orbits():
    table = table_of([at(0.0), at(0.5)], [at(0.52), at(0.01)], [at(0.02)], [at(0.53), at(0.03)])
    assert table == [{0: 0.0, 1: 0.5}, {0: 0.01, 1: 0.52}, {0: 0.02}, {0: 0.03, 1: 0.53}]
    # an attractor has the number from which an orbit came
    assert table_of([at(0.0)], [at(0.9, ~0)]) == [{0: 0.0}, {0: 0.9}]
    assert table_of([at(0.0)], [at(0.9)]) == [{0: 0.0}, {1: 0.9}]
    # one that goes on keeps its number, whatever else leads to it
    both = table_of([at(0.0), at(0.5)], [at(0.01, ~1)])
    assert both == [{0: 0.0, 1: 0.5}, {0: 0.01}]
    # only what is not continued is carried on
    numbering = attractors.Numbering((2,))
    numbering.give([at(0.0), at(0.5)])
    assert list(numbering.absent([at(0.51)])) == [0]
    # along two parameters the last one is stepped first
    groups = [at(0.0)], [at(0.05), at(0.6)], [at(0.1), at(1.2)], [at(0.12), at(0.62)]
    rows = [{0: 0.0}, {0: 0.05, 1: 0.6}, {0: 0.1, 2: 1.2}, {0: 0.12, 1: 0.62}]
    assert table_of(*groups, shape=(2, 2)) == rows


def test_a_given_state_is_where_other_components_begin_and_without_one_they_rest():
    document = {
        "system": "ssul-set6",
        "vary": {"x2_0": {"values": [0.01, 0.02]}},
        "start": {"state": [1e-3, 0.1, 9.0, -0.2]},
        "record": {"want": ["section"]},
        "sampling": {"transient": 0, "periods": 1},
    }
    scan = nv.load_scan(document)
    assert scan.start.policy == "state"
    assert nv.load_scan(scan.document()).hash == scan.hash
    starts = Computer(scan).orbits(np.arange(2))[1]
    rest = scan.system.rest
    expected = [[1e-3, 0.1, 1e-3 - (x2 - rest), 0.1 + 0.2] for x2 in (0.01, 0.02)]
    assert np.array_equal(starts, expected)
    changes = {"system": "ssul-set6", "set": {}, "vary": {"v2_0": {"values": [0.5]}}}
    scan = nv.load_scan({**PLANE, **changes})
    assert Computer(scan).orbits(np.arange(1))[1].tolist() == [[0.0, 0.0, 0.0, -0.5]]


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"vary": {"x3_0": {"values": [0.0]}}}, "unknown axis 'x3_0'; did you mean 'x_0'"),
        ({"vary": {"x2_0": {"values": [0.0]}}}, "unknown axis 'x2_0'; did you mean 'x_0'"),
        ({"start": {"policy": "random", "count": 3}}, "x_0 is varied: orbits start at rest"),
        ({"start": {"policy": "up"}}, "x_0 is varied"),
        ({"vary": {"e": {"values": [0.5]}}, "start": {"policy": "up"}}, "want 'attractor'"),
        ({"start": {"state": [1.0]}}, "must be a list of 4 numbers, or of 2"),
        ({"start": {"state": [1.0, 2.0, 3.0, 4.0]}}, "state has 4 numbers"),
        ({"start": {"policy": "state"}}, "which needs one"),
        ({"start": {"policy": "rest", "state": [0.0, 0.0]}}, "a state belongs to policy 'state'"),
        ({"vary": {"x_0": {"values": [float("inf")]}}}, "x_0 = inf"),
        ({"vary": {"phase": {"values": [0.0, 7.0]}}}, "phase = 7.0 is not allowed"),
        ({"vary": {"phase": {"values": [-1.0, 1.0]}}}, "from 0 to 6.28319"),
        (
            {"vary": {"phase": {"values": [1.0]}}, "start": {"policy": "random", "count": 3}},
            "phase is varied: orbits start at rest",
        ),
        ({"vary": {"v_0": {"values": [1.0]}}, "start": {"policy": "up", "phase": 1.0}}, "'rest'"),
    ],
)
def test_a_wrong_request_is_refused(changes, message, error_of):
    assert message in error_of(nv.load_scan, {**PLANE, **changes})


@pytest.mark.parametrize(
    ("words", "line"),
    [
        ("--vary x2_0=0:0.1:3 --start 0,0,0.1", "must be a list of 4 numbers"),
        ("--vary x2_0=0:0.1:3 --start 0,one,0,0", "must be a number"),
        ("--start @1.5", "--start @1.5: a state or rest stands before the @"),
        ("--start rest@1.5 --vary phase=0:6:4", "phase is varied, and phase = 1.5"),
    ],
)
def test_a_state_or_phase_on_the_command_line(words, line, refusal):
    assert line in refusal("bifurcation", "--record", "attractor", "--dry-run", *words.split())


@pytest.mark.long
def test_labels_of_ten_thousand_cells_are_those_of_plain_following():
    document = {
        **PLANE,
        "system": "ssul-set6",
        "set": {"omega": 7.7},
        "vary": {
            "x2_0": {"start": 0.1, "stop": 0.26, "num": 1000},
            "v2_0": {"start": -1.0, "stop": 1.0, "num": 1000},
        },
    }
    scan = nv.load_scan(document)
    chosen = np.sort(np.random.default_rng(1).choice(scan.lanes, 10_000, replace=False))
    computer = Computer(scan)
    early = computer.lanes(*computer.orbits(chosen))["label"]
    plain = Computer(replace(scan, want=("regime",)))
    assert (early == finals(plain.lanes(*plain.orbits(chosen))["label"])).all()
