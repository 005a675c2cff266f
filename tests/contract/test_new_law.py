"""A new contact law is one file and one entry of the model: done here with an example.

Two springs of a wall, the second from a depth on. The test applies the change that `tests/changes`
shows to a copy of the package, and compares states, labels, multipliers and derivatives by the
law's constants with a solver that shares nothing with the kernels.
"""

import json
import shutil
import sys
from functools import partial
from pathlib import Path
from types import ModuleType
from typing import NamedTuple

import numpy as np
import pytest
from commands import changed, printed
from scipy.integrate import solve_ivp

from nlds_vines.kernels.numerics import stored_code
from nlds_vines.kernels.scene import law

ROOT = Path(__file__).parents[2]

CONSTANTS = {"ka": 2e5, "za": 0.01, "kb": 2e6}
RECORDED = (6.0, 6.9, 7.2)  # omega [rad/s]: the deepest contacts of each pass za
JUDGED = (6.0, 7.8)  # with impacts beyond za, and without
PERIODS = 4

PROGRAM = """
import json, sys
import numpy as np
import nlds_vines as nv
from nlds_vines.engine.section_map import SectionMap

constants, recorded, judged, periods = json.loads(sys.argv[1])
system = nv.load_system("ssul-set6", law="bilinear", **constants)

def about(omega):
    there = system.with_(omega=omega)
    return {**there.parameters, "gap": float(there.cells()["near"]), "rest": there.rest}

found = {"orbits": [], "regimes": []}
for omega in recorded:
    orbit = nv.simulate(system.with_(omega=omega), periods, record=("section", "impacts", "energy"))
    impacts = {name: orbit.impacts[name].tolist() for name in ("depth", "force")}
    found["orbits"].append([about(omega), orbit.section.tolist(), impacts])
for omega in judged:
    regime = nv.classify(system.with_(omega=omega), quiet=True)
    pairs = [[z.real, z.imag] for z in np.asarray(regime.multipliers).tolist()]
    kind = [regime.label, regime.period, regime.impacts]
    found["regimes"].append([about(omega), np.asarray(regime.point).tolist(), pairs, *kind])
there = SectionMap(system.with_(omega=recorded[0]), tuple(constants))
state = np.array([-0.01, 0.3, 0.02, 0.5])
cycle = there.at(np.concatenate([state, list(constants.values())]), 2)
found["slopes"] = [about(recorded[0]), state.tolist(), cycle.slopes.tolist()]
print(json.dumps(found))
"""


class Twin:
    """Equation (5) with that wall, by SciPy: from event to event, each piece smooth."""

    def __init__(self, p):
        self.p, self.period, self.depths = p, 2 * np.pi / p["omega"], (0.0, p["za"])
        self.passed = [0, 0, 0]  # how often each piece was left for one that is deeper

    def depth(self, y):
        return y[0] - y[2] + self.p["rest"] - self.p["gap"]

    def rates(self, t, y, piece):
        """Return the derivatives of (x1, v1, x2, v2) off the wall, on one spring, or on two."""
        p, (x1, v1, x2, v2), z = self.p, y, self.depth(y)
        force = (0.0, p["ka"] * z, p["ka"] * p["za"] + p["kb"] * (z - p["za"]))[piece]
        pull = p["k2"] * (x1 - x2 + p["rest"]) + p["c2"] * (v1 - v2) + force
        push = p["P"] * np.cos(p["omega"] * t) - p["k1"] * x1 - p["c1"] * v1
        return v1, (push - pull) / p["m1"], v2, pull / p["m2"]

    def passage(self, depth, sign):
        """Return the event that a depth is passed upwards (1) or downwards (-1)."""

        def passed(t, y, piece):
            return self.depth(y) - depth

        passed.terminal, passed.direction = True, sign
        return passed

    def sections(self, y, periods):
        """Return the states (periods, 4) at the ends of periods from a state at phase zero."""
        t, piece, states = 0.0, sum(self.depth(y) > depth for depth in self.depths), []
        upwards, downwards = ([self.passage(d, sign) for d in self.depths] for sign in (1, -1))
        for n in range(1, periods + 1):
            while t < n * self.period:
                # a piece ends at the next depth, or at that which began it
                deeper, back = upwards[piece : piece + 1], downwards[:piece][-1:]
                done = solve_ivp(
                    self.rates, (t, n * self.period), y, "DOP853", args=(piece,),
                    events=deeper + back, rtol=3e-14, atol=1e-15,
                )  # fmt: skip
                t, y = done.t[-1], done.y[:, -1]
                if done.status == 1:
                    is_deeper = bool(deeper) and len(done.t_events[0]) > 0
                    self.passed[piece] += is_deeper
                    piece += 1 if is_deeper else -1
            t = n * self.period
            states.append(y)
        return np.array(states)

    def end(self, periods, y):
        return self.sections(y, periods)[-1]


def derivative(f, x, steps):
    """Return the derivatives of f by each component of x, as columns, by central differences."""
    columns = []
    for e, step in zip(np.diag(steps), steps, strict=True):
        far, near = f(x + e) - f(x - e), f(x + 0.5 * e) - f(x - 0.5 * e)
        columns.append((8 * near - far) / (6 * step))
    return np.array(columns).T


@pytest.fixture(scope="module")
def computed(tmp_path_factory):
    folder = changed(tmp_path_factory.mktemp("changed"), "contact_law")
    place = folder / "nlds_vines" / "kernels" / "__pycache__"
    place.mkdir()
    for file in (stored_code.folder() or place).glob("*.compiled"):  # kernels that know no law
        shutil.copy(file, place)
    program = "-P", "-c", PROGRAM, json.dumps([CONSTANTS, RECORDED, JUDGED, PERIODS])
    return json.loads(printed(*program, cwd=folder, PYTHONPATH=str(folder)))


pytestmark = pytest.mark.kernels


def test_its_change_is_one_file_and_one_entry_of_the_model(tmp_path):
    files = {path.relative_to(ROOT) for path in (ROOT / "nlds_vines").rglob("*.py")}
    new = changed(tmp_path, "contact_law")
    there = {path.relative_to(new) for path in (new / "nlds_vines").rglob("*.py")}
    differ = {path for path in files if (ROOT / path).read_bytes() != (new / path).read_bytes()}
    assert there - files == {Path("nlds_vines/kernels/laws/bilinear.py")}
    assert differ == {Path("nlds_vines/model/parameters.py")}


def test_states_are_those_of_another_solver(computed):
    for p, section, impacts in computed["orbits"]:
        twin, start = Twin(p), np.array([0.0, 0.0, p["rest"], 0.0])
        np.testing.assert_allclose(section, twin.sections(start, PERIODS), rtol=0, atol=1e-11)
        assert twin.passed[0] == len(impacts["depth"])
        depth, force = np.array(impacts["depth"]), np.array(impacts["force"])
        assert depth.max() > p["za"]
        expected = p["ka"] * np.minimum(depth, p["za"]) + p["kb"] * np.fmax(depth - p["za"], 0.0)
        np.testing.assert_allclose(force, expected, rtol=1e-9)


def test_label_and_multipliers_are_those_of_another_solver(computed):
    for beyond, (p, point, pairs, *regime) in zip((1, 0), computed["regimes"], strict=True):
        twin, y, (label, period, impacts) = Twin(p), np.array(point), regime
        sections = twin.sections(y, period)
        assert label == f"{'' if period == 1 else period}T,{impacts}"
        assert twin.passed[:2] == [impacts, beyond]
        np.testing.assert_allclose(sections[-1], y, rtol=0, atol=1e-9)
        assert all(np.abs(one - y).max() > 1e-6 for one in sections[:-1])
        matrix = derivative(partial(twin.end, period), y, [1e-5] * 4)
        ours = np.sort_complex([complex(*pair) for pair in pairs])
        theirs = np.sort_complex(np.linalg.eigvals(matrix))
        np.testing.assert_allclose(ours, theirs, rtol=0, atol=1e-6)


def test_derivatives_by_its_constants_are_those_of_another_solver(computed):
    p, (x1, v1, r, s), slopes = computed["slopes"]
    start = np.array([x1, v1, x1 - r + p["rest"], v1 - s])

    def image(constants):
        there = Twin({**p, **dict(zip(CONSTANTS, constants, strict=True))})
        x1, v1, x2, v2 = there.sections(start, 2)[-1]
        return np.array([x1, v1, x1 - x2 + p["rest"], v1 - v2])

    constants = np.array(list(CONSTANTS.values()))
    theirs = derivative(image, constants, 1e-3 * constants).T
    scale = np.abs(theirs).max(axis=1, keepdims=True)
    np.testing.assert_allclose(np.array(slopes) / scale, theirs / scale, rtol=0, atol=1e-6)


class Mute(NamedTuple):
    gap: float


def test_a_law_that_lacks_a_kernel_is_refused_in_words(monkeypatch):
    monkeypatch.setitem(sys.modules, "nlds_vines.kernels.laws.mute", ModuleType("mute"))
    monkeypatch.setattr(Mute, "__module__", "nlds_vines.kernels.laws.mute")
    with pytest.raises(TypeError, match="has no kernel 'elastic', which each law must have"):
        law.elastic(Mute(0.0), 1.0, 0.0, 0.0)
