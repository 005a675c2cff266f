"""All numbers of all kinds under a force and on a moving ground, beside SciPy, inertial frame."""

import math

import numpy as np
import pytest
from inertial import V1, V2, X1, X2, Course, Twin, W, Y
from scipy.integrate import solve_ivp

import nlds_vines as nv
from nlds_vines.model.system import System

NUMBERS = {
    "m1": 1.0, "k1": 1.3, "c1": 0.11, "P": 1.0, "omega": 1.0, "m2": 0.2, "k2": 0.14, "c2": 0.03,
    "C": 0.06, "D": 0.05, "L": 0.4, "V": 0.3, "g": 0.9, "C_2": 0.04, "m": 1.0, "k": 1.3, "c": 0.11,
    "Y": 0.1,
}  # fmt: skip
LAWS = {
    "hertz": {"K": 60.0},
    "hunt-crossley": {"K": 60.0, "hunt_crossley": 0.4},
    "power": {"K": 30.0, "exponent": 1.2},
    "linear": {"kc": 30.0, "cc": 0.4},
    "restitution": {"e": 0.9},
}
KINDS = ("none", "tmd", "ssul", "ssbl", "ssvi-b", "ssvi-c", "oscillator", "oscillator-2", "ball")
CASES = [(kind, "hertz", 0.0) for kind in KINDS]
CASES += [("ssul", law, 0.0) for law in LAWS if law != "hertz"]
CASES += [("oscillator", law, 0.0) for law in LAWS if law != "hertz"]
CASES += [("ssul", law, -0.1) for law in LAWS if law != "restitution"]
CASES += [("oscillator", "hertz", -0.1)]
"""Kind, law of its contacts, and what is added to C: a negative clearance presses at the start."""

PULSE, LENGTH = 0.7, 2.2  # amplitude and duration of the half-sine
TONE, OMEGA, PHASE = 0.3, 1.7, 0.4
DURATION, SAMPLES, HEIGHT = 9.0, 8, 0.2
PRECISE = 2e-6  # of SciPy where the force has a kink
SHARES = (0.01, 0.1, 0.5)

SQUARE, C1, C2, CONTACT, WORK = range(W + 1, W + 6)  # further unknowns of the twin


def system_of(kind, law, widening):
    """Return a system of a kind, its clearance changed by so much."""
    from nlds_vines.model.scenes import SCENES

    parameters = {name: NUMBERS[name] for name in SCENES[kind].parameter_names}
    if "C" in parameters:
        parameters["C"] += widening
    walls = LAWS[law] if SCENES[kind].walls else {}
    name = "power" if law == "hunt-crossley" else law
    if law == "hunt-crossley":
        walls = {**walls, "exponent": 1.5}
    return System(kind, parameters | walls, law=name if walls else "hertz")


def load_at(t):
    """Return the force, or the ground's acceleration."""
    pulse = PULSE * math.sin(math.pi * t / LENGTH) if t < LENGTH else 0.0
    return pulse + TONE * math.cos(OMEGA * t + PHASE)


class Loaded(Twin):
    """A twin under the load, by a force or by its ground, with energies as further unknowns."""

    def __init__(self, system, shaken):
        super().__init__(system, **{"ground" if shaken else "force": load_at})

    def integrands(self, a1, lost, t, y):
        v1, v2 = y[V1] - y[W], y[V2] - y[W]
        shaking = -self.ground(t) * (self.m1 * v1 + self.m2 * v2)
        return [
            (y[X1] - y[Y]) ** 2, self.c1 * v1**2, self.c2 * (y[V2] - y[V1]) ** 2, lost,
            self.force(t) * v1 + shaking,
        ]  # fmt: skip

    def course(self):
        """Return the course, its solutions cut at kinks and rigid impacts; note their impulses."""
        y, t, solutions, self.impulses = np.zeros(WORK + 1), 0.0, [], []
        y[X2], y[X1] = self.rest, HEIGHT if self.kind == "ball" else 0.0
        self.begin = self.energies(y)[2]
        touches = [
            lambda t, y, i=i: self.walls(y[X1] - y[Y], y[X2] - y[X1])[i][0]
            for i in range(len(self.walls(0.0, 0.0)) if self.rigid else 0)
        ]
        for touch in touches:
            touch.direction, touch.terminal = 1.0, True
        while t < DURATION:
            end = LENGTH if t < LENGTH else DURATION
            run = solve_ivp(
                self.slopes, (t, end), y, "DOP853", rtol=1e-11, atol=1e-12, max_step=0.02,
                dense_output=True, events=touches,
            )  # fmt: skip
            assert run.success, run.message
            solutions.append(run)
            t, y = run.t[-1], run.y[:, -1].copy()
            if run.status == 1:
                self.impulses.append(self.rebound(y))
        return Course(solutions)

    def rebound(self, y):
        """Let a rigid impact turn the relative speed; return its impulse [N s]."""
        mass = 1.0 / (1.0 / self.m1 + 1.0 / self.m2) if self.damped else self.m1
        struck = y[V2] - y[V1] if self.damped else y[V1] - y[W]
        change, e = -(1.0 + self.constants["e"]) * struck, self.constants["e"]
        y[CONTACT] += 0.5 * mass * struck**2 * (1.0 - e**2)
        y[V1] += -mass * change / self.m1 if self.damped else change
        y[V2] += mass * change / self.m2 if self.damped else 0.0
        return mass * abs(change)


def numbers_of(twin, course):
    """Return the numbers of a response history by name."""
    end = course.solutions[-1].y[:, -1]
    most, when = course.largest(lambda t, y: twin.energies(y)[0])
    numbers = {
        "E1max": most,
        "x1_max": course.largest(lambda t, y: y[X1] - y[Y])[0],
        "v1_max": course.largest(lambda t, y: y[V1] - y[W])[0],
        "x1_rms": math.sqrt(end[SQUARE] / DURATION),
        "energy_in": twin.begin + end[WORK],
    }
    numbers["shear_max"] = twin.k1 * numbers["x1_max"]
    for share in SHARES:
        numbers[f"last_{100 * share:g}"] = course.last_above(
            lambda t, y: twin.energies(y)[0], share * most
        )
    if not twin.rigid:
        numbers["a1_max"] = course.largest(lambda t, y: twin.at(t, y)[0])[0]
    depths = [
        course.values(lambda t, y, i=i: twin.walls(y[X1] - y[Y], y[X2] - y[X1])[i][0])
        for i in range(len(twin.walls(0.0, 0.0)))
    ]
    if depths:
        numbers["share_contact"] = end[CONTACT] / numbers["energy_in"]
    if depths and twin.rigid:
        # an impact that the twin misses leaves it beyond the wall: many end in rest
        assert max(z.max() for wall in depths for z in wall) < 1e-8
        numbers["impact_count"] = len(twin.impulses)
        numbers["impulse_max"] = max(twin.impulses)
    elif depths:
        numbers["impact_count"] = sum(
            int(np.count_nonzero((z[:-1] <= 0.0) & (z[1:] > 0.0)))
            for z in map(np.concatenate, depths)
        )
        numbers["force_max"] = course.largest(lambda t, y: max(twin.at(t, y)[2]))[0]
    numbers["share_c1"] = end[C1] / numbers["energy_in"]
    if twin.damped:
        numbers["share_c2"] = end[C2] / numbers["energy_in"]
        numbers["E2max"] = course.largest(lambda t, y: twin.energies(y)[1])[0]
        numbers["stroke_max"] = course.largest(lambda t, y: y[X2] - y[X1] - twin.rest)[0]
    fell = numbers["last_10"] - when
    if math.isfinite(fell) and twin.k1 > 0.0:
        period = 2.0 * math.pi * math.sqrt(twin.m1 / twin.k1)
        numbers["damping_ratio"] = math.log(10.0) / (4.0 * math.pi * fell / period)
    return {name: value for name, value in numbers.items() if math.isfinite(value)}


def load_of(shaken):
    unit = "m/s^2" if shaken else "N"
    return {
        "half_sine": {"peak": PULSE, "length": LENGTH, "unit": unit},
        "tone": {"amplitude": TONE, "omega": OMEGA, "phase": PHASE, "unit": unit},
    }


@pytest.mark.parametrize("shaken", [False, True], ids=["force", "ground"])
@pytest.mark.parametrize(("kind", "law", "widening"), CASES)
def test_all_numbers_are_those_of_the_inertial_frame(kind, law, widening, shaken):
    system = system_of(kind, law, widening)
    start = {"start": {"state": (HEIGHT, 0.0)}} if kind == "ball" else {}
    histories_of = nv.response_history(
        [system], load=load_of(shaken), sampling={"duration": DURATION, "samples": SAMPLES},
        quiet=True, **start,
    )  # fmt: skip
    (fall,) = histories_of.results.values()
    twin = Loaded(system, shaken)
    course = twin.course()
    wanted = numbers_of(twin, course)
    have = {name for name, value in fall.numbers.items() if math.isfinite(value)}
    assert have - {"balance"} == set(wanted)
    for name, value in wanted.items():
        assert fall.numbers[name] == pytest.approx(value, rel=PRECISE), name
    assert fall.numbers["balance"] < 1e-9
    states = np.array([course.state(t) for t in fall.time])
    energies = np.array([twin.energies(y) for y in states])
    histories = {
        "x1": states[:, X1] - states[:, Y], "x2": states[:, X2] - states[:, Y],
        "E1": energies[:, 0], "E2": energies[:, 1], "work": twin.begin + states[:, WORK],
    }  # fmt: skip
    gone = {"c1": C1, "c2": C2, "contact": CONTACT}
    histories |= {key: states[:, column] for key, column in gone.items()}
    for name, values in histories.items():
        mine = fall.dissipated[name] if name in gone else getattr(fall, name)
        if np.isfinite(mine).any():
            np.testing.assert_allclose(mine, values, rtol=PRECISE, atol=1e-7, err_msg=name)
        else:
            lacks = ("contact",) if twin.damped else ("x2", "E2", "c2", "contact")
            assert name in lacks


def test_a_damper_that_a_rigid_wall_presses_begins_with_the_energy_of_its_spring():
    system = nv.load_system("ssul-set6", C=-0.05, law="restitution", e=0.6)
    numbers = nv.response_history([system], impulse=300.0, duration=3.0, quiet=True)[
        "ssul-set6"
    ].numbers
    stored = 0.5 * system.parameters["k2"] * 0.05**2
    assert numbers["energy_in"] == pytest.approx(45.0 + stored, rel=1e-14)
    assert numbers["balance"] < 1e-13


def test_a_ball_that_falls_dissipates_its_weight_s_energy():
    system = nv.load_system("bouncing-ball")
    result = nv.response_history([system], start={"state": (1.0, 0.0)}, duration=3.0, quiet=True)
    numbers = result["bouncing-ball"].numbers
    assert numbers["energy_in"] == pytest.approx(system.parameters["m"] * system.parameters["g"])
    assert numbers["share_contact"] == pytest.approx(1.0, rel=1e-14)  # it has come to rest
    assert numbers["balance"] < 1e-14
