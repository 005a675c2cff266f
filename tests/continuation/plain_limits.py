"""A law in its limit is the law it goes over into: the map of a period and all its derivatives.

e -> 0 of restitution, n -> 1 of the power law, dampings -> 0, a load -> 0, and sticking for no
time. What a limit changes shrinks with what is left of it. (Run by `contract/test_plain.py`.)
"""

import numpy as np
import pytest
from scipy.linalg import expm

from nlds_vines import System, continue_branch, load_system
from nlds_vines.continuation.arclength import Point
from nlds_vines.continuation.special_curves import augmented
from nlds_vines.engine.section_map import Cycle, SectionMap
from nlds_vines.engine.solver_settings import Settings
from nlds_vines.model.linear_response import flow_matrix

SET_6 = load_system("ssul-set6")
AT_WALL = [0.0, 0.2, 0.03, 0.4]  # x1, v1, r, s: an impact in the first period
STOP = {"m": 1.0, "k": 1.0, "c": 0.1, "C": 1.0, "P": 2.0, "omega": 1.5}
TABLE = {"m": 1.0, "g": 9.81, "Y": 0.04, "omega": 30.0}
DROPPED = [0.0, 1.0]


def power(**law):
    return SET_6.with_(law="power", K=1e5, **law)


def rigid(**law):
    return SET_6.with_(law="restitution", **law)


def ball(**law):
    return System("ball", TABLE | law, law="restitution")


def stop(**law):
    return System("oscillator", STOP | law, law="restitution")


def touching(system, time):
    """Return the state (x, v) at phase zero of a free motion that touches at `time` with 1 m/s."""
    p = system.parameters
    phase = p["omega"] * time
    at_touch = np.array([p["C"], 1.0, 0, 0, np.cos(phase), np.sin(phase)])
    return (expm(flow_matrix(system) * -time) @ at_touch)[:2]


LINEAR = SET_6.with_(law="linear", kc=1e5, cc=0.0)
SHAKEN = {"m": 1.0, "k": 0.0, "c": 0.0, "C": 1e6, "C_2": 0.0, "P": 0.04 * 900.0, "omega": 30.0}
# by name: the system with so little of something left, that in the limit, a start, parameters
LIMITS = {
    "e of a ball": (lambda d: ball(e=d), ball(e=0.0), DROPPED, ("Y", "g")),
    "e of a stop": (lambda d: stop(e=d), stop(e=0.0), touching(stop(e=0.0), 2.0), ("P", "omega")),
    "e of a damper": (lambda d: rigid(e=d), rigid(e=0.0), AT_WALL, ("omega", "m2")),
    "n of a power": (lambda d: power(exponent=1.0 + d), LINEAR, AT_WALL, ("omega", "m2")),
    "damping of a power": (
        lambda d: power(exponent=1.5, hunt_crossley=d), power(exponent=1.5), AT_WALL, ("omega",)
    ),
    "damping of Hertz": (
        lambda d: SET_6.with_(K=1e6, hunt_crossley=d), SET_6.with_(K=1e6), AT_WALL, ("omega",)
    ),
    "cc of a soft stop": (lambda d: LINEAR.with_(cc=1e4 * d), LINEAR, AT_WALL, ("omega", "kc")),
    "cc of a joint": (
        lambda d: SET_6.with_(law="kelvin-voigt", kc=1e5, cc=1e4 * d), LINEAR, AT_WALL,
        ("omega", "kc"),
    ),
    "c of the structure": (lambda d: stop(e=0.5, c=d), stop(e=0.5, c=0.0), [0.0, 0.5], ("P",)),
    "c of the damper": (
        lambda d: rigid(e=0.6, c2=10.0 * d), rigid(e=0.6, c2=0.0), AT_WALL, ("k2",)
    ),
    "load": (
        lambda d: ball(e=0.5, g=d),
        System("oscillator-2", {**SHAKEN, "e": 0.5}, law="restitution"), [0.05, -1.0], ("e",),
    ),
}  # fmt: skip


def mapped(system, start, names):
    """Return the image of a start after a period, its derivatives, and the impacts."""
    section_map = SectionMap(system, names, Settings(1e-13))
    values = [system.parameters[name] for name in names]
    cycle = section_map.at(np.array([*start, *values]), 1)
    size = section_map.size
    return cycle.points[0, :size], cycle.matrix, cycle.slopes, cycle.counts


def off(value, expected, relative=True):
    """Return by how much arrays differ, each relative to the largest number in it if asked."""
    pairs = zip(value[:3], expected[:3], strict=True)
    return np.array([np.abs(a - b).max() / (np.abs(b).max() if relative else 1) for a, b in pairs])


@pytest.mark.parametrize("name", LIMITS)
def test_what_a_limit_changes_shrinks_with_what_is_left(name):
    of, last, start, names = LIMITS[name]
    limit = mapped(last, start, names)
    assert sum(limit[3]) > 0
    assert all(np.isfinite(array).all() for array in limit[:3])
    far, near = (mapped(of(d), start, names) for d in (1e-4, 1e-6))
    assert far[3] == near[3] == limit[3]
    # ln z of the power's own derivatives is all that is not linear
    assert (off(near, limit) <= 0.015 * off(far, limit) + 1e-9).all(), name


def test_sticking_for_no_time_is_leaving_at_once():
    system = stop(e=0.0)
    p = system.parameters
    release = np.arccos(p["k"] * p["C"] / p["P"]) / p["omega"]
    before = []
    for d in (1e-3, 1e-5):
        pair = [mapped(system, touching(system, release + d * i), ("P",)) for i in (-1, 1)]
        assert pair[0][3] == pair[1][3] == (1, 0)
        assert np.abs(pair[0][1]).max() < 1e-14 < np.abs(pair[1][1]).max()  # the first one stuck
        before.append(off(*pair, relative=False).max())
    assert before[1] < 0.015 * before[0]


def test_a_ball_that_forgets_its_speed_doubles_in_closed_form():
    """With e = 0: mu = 1 - sqrt(Gamma^2 - pi^2), so -1 at Gamma^2 = pi^2 + 4."""
    unit = TABLE["g"] / TABLE["omega"] ** 2
    path = continue_branch(ball(e=0.0, Y=3.7 * unit), "Y", (3.68 * unit, 3.76 * unit), DROPPED)
    (row,) = path.special_points
    assert (row.kind, row.before) == ("PD", "T,1")
    assert row.value == pytest.approx(np.hypot(np.pi, 2.0) * unit, rel=1e-12)
    (branch,) = path.branches
    gamma = branch.parameter / unit
    expected = np.stack([1.0 - np.sqrt(gamma**2 - np.pi**2), 0.0 * gamma], axis=-1)
    np.testing.assert_allclose(branch.multipliers, expected, rtol=0, atol=1e-9)
    assert branch.determinant_error.max() < 1e-12


@pytest.mark.parametrize("kind", ["PD", "NS"])
def test_what_vanishes_at_a_point_changes_its_sign_there(kind):
    """Of a matrix of rank two, whose other multipliers are exactly 0."""
    turn, mixed = 1.1, np.random.default_rng(3).normal(size=(4, 4))

    def cycle(size):
        block = np.zeros((4, 4))
        block[:2, :2] = [[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]]
        if kind == "PD":
            block[:2, :2] = [[-1.0, 0.5], [0.0, 0.3]]
        matrix = mixed @ (size * block) @ np.linalg.inv(mixed)
        multipliers = np.array(np.linalg.eigvals(size * block), complex)
        return Cycle(
            np.zeros(4), np.zeros(1), np.zeros((1, 4)), (1, 0), matrix, np.zeros((1, 4)),
            multipliers, 0.0, 1.0, 1.0, 1.0, -np.inf, np.ones(4),
        )  # fmt: skip

    on, below, above = cycle(1.0), cycle(1.0 - 1e-4), cycle(1.0 + 1e-4)
    tests = [Point(c, np.ones(5), np.ones(5), 1.0).tests[kind] for c in (below, on, above)]
    curve = [augmented(kind, on)(c) for c in (below, on, above)]
    for values in (tests, curve):
        assert values[0] * values[2] < 0.0
        assert abs(values[1]) < 1e-8 * abs(values[0] - values[2])
