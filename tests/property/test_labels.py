"""A label is a property of the orbit: not of the method, the cut, the phase, or the effort.

From rest two methods may end on different attractors: round-off decides which after a chaotic
transient. So the second method starts where the first one arrived, at the point of the periodic
orbit or at the last state; the judgement and the orbit itself are compared. Chaos that one method
still sees and the other has seen end is followed on by both: it must end, or last, in both.
"""

import itertools
from dataclasses import dataclass
from functools import partial

import numpy as np
import pytest

from nlds_vines.bifurcation.request import load_scan
from nlds_vines.bifurcation.run import Computer
from nlds_vines.engine import batch
from nlds_vines.engine.batch import parts_of
from nlds_vines.kernels.cells.cells import run_cell
from nlds_vines.kernels.orbit.orbit import STATE_SIZE
from nlds_vines.kernels.scene import codes as ev
from nlds_vines.kernels.scene.codes import OK
from nlds_vines.kernels.scene.scene import CellBuffers, Span
from nlds_vines.model.labels import final
from nlds_vines.model.scenes import SCENES
from nlds_vines.runs.executors import use_threads

pytestmark = pytest.mark.kernels

WANT = ["regime", "settling", "lyapunov", "evidence"]
OMEGA, FORCE = (5.0, 8.0), (400.0, 1200.0)
OPEN = ("undetermined", "failed")
LONG = 20_000  # forcing periods after which a chaotic transient of the plane has ended


@dataclass
class Judged:
    """Lanes that have run: their datasets, flat, and what kernels call their states."""

    arrays: dict
    points: np.ndarray
    ends: np.ndarray

    @property
    def labels(self):
        return self.arrays["label"]

    @property
    def arrived(self):
        """The point of a periodic orbit, otherwise the last state, as kernels have it."""
        return np.where((self.arrays["periodicity"] > 0)[:, np.newaxis], self.points, self.ends)


def judge(cells, starts=None, method="exact", effort="standard", transient=240, periods=60):
    """Run a lane for each cell from `starts` (x1, v1, r, s), by default at rest, and judge it."""
    scan = load_scan(
        {
            "system": "ssul-set6",
            "vary": {"omega": {"values": [6.0]}},
            "sampling": {
                "method": method, "effort": effort, "transient": transient, "periods": periods
            },
            "record": {"want": WANT},
        }
    )  # fmt: skip
    chains = np.ascontiguousarray(cells.reshape(-1, 1))
    starts = np.zeros((len(chains), 4)) if starts is None else np.ascontiguousarray(starts)
    kernels = Computer(scan).kernels
    out = kernels.run(chains, starts, transient, periods)
    verdicts = kernels.verdicts(out, chains)
    rows = out.evidence[:, 0]
    point = rows[:, ev.POINT : ev.POINT + 4]
    return Judged(
        {name: a[:, 0] for name, a in verdicts.items()}, point, out.buffers.ends[:, 0, 1, :4]
    )


def cells_of(**values):
    scan = load_scan({"system": "ssul-set6", "vary": {"omega": {"values": [6.0]}}})
    return scan.system.cells(values)


def random_cells(count, seed=20):
    generator = np.random.default_rng(seed)
    return cells_of(omega=generator.uniform(*OMEGA, count), P=generator.uniform(*FORCE, count))


def grid(across=16, up=10):
    """Return a grid of cells where much happens: 3T, chaos, chaotic transients, long periods."""
    omega, force = np.meshgrid(np.linspace(7.2, 7.9, across), np.linspace(600, 1100, up))
    return cells_of(omega=omega.ravel(), P=force.ravel())


def ends_of(labels):
    return np.array([final(label) for label in labels])


def differ(first, second):
    """Return the lanes whose final regimes differ, where both are determined."""
    one, two = ends_of(first.labels), ends_of(second.labels)
    return np.flatnonzero((one != two) & ~np.isin(one, OPEN) & ~np.isin(two, OPEN))


@pytest.mark.parametrize(
    ("count", "least"), [(100, 4), pytest.param(2000, 8, marks=pytest.mark.long)]
)
def test_both_methods_agree_on_random_cells(count, least):
    """Wherever both are determined, as most are: in so many final regimes at least."""
    cells = random_cells(count)
    exact = judge(cells)
    classical = judge(cells, exact.arrived, "rk4", transient=40, periods=80)
    one, two = ends_of(exact.labels), ends_of(classical.labels)
    left = differ(exact, classical)
    if left.size:  # these differ to the end, or do not
        assert set(one[left]) | set(two[left]) >= {"chaos"}
        further = judge(cells[left], exact.ends[left], transient=LONG)
        again = judge(cells[left], further.arrived, "rk4", transient=40, periods=80)
        left = left[differ(further, again)]
    cases = zip(cells[left], exact.labels[left], classical.labels[left], strict=True)
    assert not left.size, [(c["omega"], c["P"], a, b) for c, a, b in cases]
    determined = ~np.isin(one, OPEN) & ~np.isin(two, OPEN)
    assert determined.mean() > 0.98
    assert len(set(one[determined])) >= least
    periodic = (exact.arrays["periodicity"] > 0) & (one == two)
    radius = [np.abs(j.arrays["multipliers"][periodic, 0] @ [1, 1j]) for j in (exact, classical)]
    np.testing.assert_allclose(*radius, atol=1e-4)


def test_threads_and_company_do_not_matter(monkeypatch):
    monkeypatch.setattr(batch, "PIECE_PERIODS", 1)  # however short, every lane is a piece
    cells = grid()
    try:
        use_threads(None)
        together = judge(cells)
        use_threads(1)
        alone = judge(cells)
        parts = [judge(piece) for piece in np.array_split(cells, 7)]
    finally:
        use_threads(None)
    for name, values in together.arrays.items():
        np.testing.assert_array_equal(values, alone.arrays[name])
        joined = np.concatenate([part.arrays[name] for part in parts])
        np.testing.assert_array_equal(values, joined)


@pytest.mark.parametrize(
    "make_cells", [grid, pytest.param(partial(random_cells, 2000), marks=pytest.mark.long)]
)
def test_more_effort_can_only_find_more(make_cells):
    """What is known stays, but for chaos and tori that end in a periodic orbit."""
    cells = make_cells()
    judged = [judge(cells, effort=effort) for effort in ("quick", "standard", "thorough")]
    for less, later in itertools.pairwise(judged):
        assert not (less.arrays["periodicity"] > 0)[less.labels != later.labels].any()
        changed = np.isin(less.labels, ["chaos", "quasiperiodic"]) & (less.labels != later.labels)
        assert (later.arrays["periodicity"][changed] > 0).all()
        assert (later.arrays["watched"] >= less.arrays["watched"]).all()
    if make_cells is grid:
        unknown = [np.count_nonzero(x.labels == "undetermined") for x in judged]
        assert unknown[0] > unknown[1] >= unknown[2]
        assert "chaos" in judged[1].labels
    else:
        assert (judged[1].labels != "undetermined").mean() > 0.99


@pytest.mark.parametrize(
    ("make_cells", "least_known", "lengths"),
    [
        (grid, 0.97, ((300, 60), (300, 2000), (5000, 120))),
        pytest.param(
            partial(random_cells, 2000), 0.99, ((300, 60), (300, 2000), (3000, 120), (20_000, 60)),
            marks=pytest.mark.long,
        ),
    ],
)  # fmt: skip
def test_no_length_changes_a_result(make_cells, least_known, lengths):
    """Neither the transient nor the window changes what an orbit is, or since when."""
    cells = make_cells()
    first, *others = (judge(cells, transient=t, periods=p) for t, p in lengths)
    assert (first.labels != "undetermined").mean() >= least_known
    for other in others:
        both = (first.arrays["periodicity"] > 0) & (other.arrays["periodicity"] > 0)
        for name in ("label", "settling", "impacts_by_wall"):
            np.testing.assert_array_equal(first.arrays[name][both], other.arrays[name][both])
        one, two = ends_of(first.labels[~both]), ends_of(other.labels[~both])
        changed = {(a, b) for a, b in zip(one, two, strict=True) if a != b}
        open_ends = {"undetermined", "chaos", "quasiperiodic"}
        assert all(a in open_ends and b not in ("undetermined", a) for a, b in changed), changed


def test_the_phase_at_which_sections_are_taken_does_not_matter():
    """A force -P cos is P cos half a period later: the same orbits, cut at another phase.

    By rk4: the bounds of the exact method presume P >= 0, as the door to the kernels does.
    """
    cells = grid()
    judged = judge(cells)
    later = cells.copy()
    later["P"] = -later["P"]
    periodic = np.flatnonzero(judged.arrays["periodicity"] > 0)
    half = halfway(cells[periodic], judged.points[periodic])
    again = judge(later[periodic], half, "rk4", transient=40, periods=80)
    np.testing.assert_array_equal(ends_of(again.labels), ends_of(judged.labels[periodic]))
    radius = [
        np.abs(a["multipliers"][i, 0] @ [1, 1j])
        for a, i in ((judged.arrays, periodic), (again.arrays, slice(None)))
    ]
    np.testing.assert_allclose(*radius, atol=1e-4)


def halfway(cells, points):
    """Return the states (x1, v1, r, s) half a forcing period after `points`."""
    parts, states = parts_of("exact", SCENES["ssul"]), np.empty((len(cells), 4))
    for i, (cell, point) in enumerate(zip(cells, points, strict=True)):
        state, section = np.zeros(STATE_SIZE), np.empty((2, 4))
        state[:4] = point
        record = np.array([cell]).view(np.recarray)[0]
        code = run_cell(parts, record, state, Span(0, 1, 2), CellBuffers(section=section))
        assert code == OK
        x1, v1, x2, v2 = section[0]
        states[i] = x1, v1, x1 - x2 + cell["rest"], v1 - v2
    return states
