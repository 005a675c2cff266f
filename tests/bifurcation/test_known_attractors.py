"""Orbits are followed until it is certain to which known attractor they belong."""

from dataclasses import replace

import numba
import numpy as np
import pytest

from nlds_vines import load_system
from nlds_vines.bifurcation.attractors.attractor_matching import (
    attractors_in,
    follow,
    form_of,
    known_of,
)
from nlds_vines.bifurcation.attractors.attractor_numbering import Learnt
from nlds_vines.kernels.cells import cycles as basins
from nlds_vines.model.scenes import SCENES
from nlds_vines.model.system import System
from nlds_vines.orbits.batch import Kernels, Wanted
from nlds_vines.orbits.kernel_inputs import parts_of
from nlds_vines.orbits.solver_settings import Settings
from nlds_vines.orbits.starts import Start, random_states, start_states

pytestmark = pytest.mark.kernels

STARTS = 60
WANT = ("regime", "lyapunov", "settling", "evidence")  # as `classify` has it


class Case:
    """Random starts of one system, what their plain verdicts are, and the attractors in these."""

    def __init__(self, name, **parameters):
        self.system = (
            System(name, parameters) if name in SCENES else load_system(name, **parameters)
        )
        settings = Settings.of("exact")
        self.parts = parts_of("exact", self.system.scene, settings)
        self.cells = np.repeat(np.atleast_1d(self.system.cells()), STARTS)
        draws = start_states(Start("random", STARTS, 3))
        self.starts = random_states(self.cells[:1], draws, self.system.scene)[0]
        kernels = Kernels(Wanted(self.system.scene, WANT, "exact", "standard", settings))
        outputs = kernels.run(self.cells[:, np.newaxis], self.starts, 600, 120)
        self.evidence = outputs.evidence[:, 0]
        found = outputs.verdicts(self.cells[:, np.newaxis])
        self.labels = np.array([str(x).split(" to ")[-1] for x in found["label"][:, 0]])
        self.settling = found["settling"][:, 0]
        self.attractors = attractors_in(self.parts, self.cells[0], self.evidence)

    def followed(self, known, most=600):
        rows = np.tile([0, len(known)], (STARTS, 1))
        return follow(self.parts, self.cells, self.starts, rows, known_of(known), most)

    def label_of(self, attractor):
        """The label of the verdicts whose closed orbit passes through an attractor's point."""
        for evidence, label in zip(self.evidence, self.labels, strict=True):
            if np.array_equal(evidence[35:39], attractor.point):
                return label
        raise AssertionError("an attractor that no verdict has found")


CASES = {
    "period one and chaos": ("ssul-set6", {"omega": 7.36}),
    "T,0 and 4T,2": ("ssul-set6", {"omega": 7.7}),
    "after transient chaos": ("ssul-set6", {"omega": 7.6}),
    "restitution": ("impact-oscillator", {"omega": 1.5, "P": 0.7}),
}


@pytest.fixture(scope="module", params=CASES, ids=list(CASES))
def case(request):
    name, parameters = CASES[request.param]
    return Case(name, **parameters)


def test_orbits_come_to_the_attractors_of_their_verdicts(case):
    drawn = case.followed(case.attractors)
    labels = [case.label_of(attractor) for attractor in case.attractors]
    for label, attractor in zip(case.labels, drawn.attractor, strict=True):
        if attractor >= 0:
            assert labels[attractor] == label
        else:
            assert label in ("chaos", "quasiperiodic", "undetermined")
    assert (drawn.status == 0).all()


def test_an_orbit_is_known_long_before_it_has_settled(case):
    drawn = case.followed(case.attractors)
    there = (drawn.attractor >= 0) & (case.settling > 0)
    assert np.median(drawn.arrival[there]) < 350
    assert (drawn.arrival[drawn.attractor >= 0] >= 0).all()
    assert (drawn.arrival[drawn.attractor < 0] == -1).all()


def test_all_of_a_region_is_drawn_to_its_attractor(case):
    """Where nothing is known but the matrix, orbits from the region need longer, but come there."""
    least = [replace(a, radius=basins.TINY * a.span) for a in case.attractors]
    draws = np.random.default_rng(9).uniform(-1.0, 1.0, (STARTS, 4))
    for number, attractor in enumerate(case.attractors):
        size = np.count_nonzero(np.diag(attractor.form.reshape(4, 4)))
        inside = draws * (np.arange(4) < size)
        lengths = [basins.norm_of(attractor.form, d) for d in inside]
        inside *= (attractor.radius * np.linspace(0.1, 1.0, STARTS) / lengths)[:, np.newaxis]
        rows = np.tile([0, len(least)], (STARTS, 1))
        starts = attractor.point + inside
        drawn = follow(case.parts, case.cells, starts, rows, known_of(least), 20000)
        assert (drawn.attractor == number).all()


def test_each_attractor_is_found_once(case):
    again = attractors_in(case.parts, case.cells[0], case.evidence[::-1], case.attractors)
    assert len(again) == len(case.attractors)
    assert len(case.attractors) >= len({x for x in case.labels if "," in x}) > 0


def test_threads_and_neighbors_change_nothing(case):
    rows = np.tile([0, len(case.attractors)], (STARTS, 1))
    known = known_of(case.attractors)
    every = follow(case.parts, case.cells, case.starts, rows, known, 600)
    for lane in (0, STARTS // 2, STARTS - 1):
        one = slice(lane, lane + 1)
        alone = follow(case.parts, case.cells[one], case.starts[one], rows[one], known, 600)
        assert alone.attractor[0] == every.attractor[lane]
        assert alone.arrival[0] == every.arrival[lane]


def test_the_matrix_shortens_lengths_by_the_rate(case):
    for known in case.attractors:
        p, m = known.form.reshape(4, 4), known.matrix.reshape(4, 4).T
        assert np.array_equal(p, p.T)
        size = np.count_nonzero(np.diag(p))
        less = known.rate**2 * p - m.T @ p @ m
        assert np.linalg.eigvalsh(less[:size, :size]).min() > -1e-9 * np.abs(p).max()


def test_an_orbit_that_does_not_return_as_foretold_is_followed_further():
    """A matrix that is not that of the attractor foretells nothing: no orbit belongs to it."""
    case = Case("impact-oscillator", omega=1.5, P=0.7)
    slow = 0.95 * np.identity(4).ravel()
    wrong = [replace(known, matrix=slow) for known in case.attractors]
    assert (case.followed(case.attractors, most=12).attractor >= 0).any()
    assert (case.followed(wrong, most=12).attractor == -1).all()


def test_two_orbits_of_one_label_are_two_attractors():
    """Between two equal stops, what is not its own mirror image has a twin: T,2 and T,3 both do."""
    stops = {"m": 1.0, "k": 1.0, "c": 0.05, "C": 0.5, "C_2": 0.5, "K": 20.0}
    case = Case("oscillator-2", **stops, P=2.0, omega=1.2)
    labels = sorted(case.label_of(known) for known in case.attractors)
    assert labels.count("T,2") == labels.count("T,3") == 2
    drawn = case.followed(case.attractors)
    assert set(drawn.attractor) == set(range(len(case.attractors)))


def test_what_a_part_has_kept_needs_no_other_kernel():
    """Arrays of a part cannot be written to, which for Numba is another type."""
    none, known = np.zeros(1, np.int64), known_of([None])
    learnt = Learnt(
        none, none, np.array(["T,0"], object), np.zeros((1, 3)), np.zeros((1, 2)), known_of([None])
    )
    arrays = learnt.arrays()
    for array in arrays.values():
        array.setflags(write=False)
    assert numba.typeof(arrays["forms"]) != numba.typeof(known.forms)
    assert numba.typeof(tuple(Learnt.of(arrays).known)) == numba.typeof(tuple(known))


def test_lengths_of_a_matrix_of_slow_decay():
    matrix = np.zeros(16)
    matrix[[0, 5, 10, 15]] = 0.999999, 0.5, -0.3, 0.0
    matrix[4] = 100.0  # strongly sheared
    form = form_of(matrix, [1.0] * 4, 0.9999995)
    p, m = form.reshape(4, 4), matrix.reshape(4, 4).T
    assert np.linalg.eigvalsh(0.9999995**2 * p - m.T @ p @ m).min() > 0.0
    assert basins.norm_of(form, np.array([0.0, 0.0, 0.0, 2.0])) == pytest.approx(2.0)
