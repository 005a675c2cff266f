"""All numbers of all kinds under a force and on a moving ground, beside SciPy, inertial frame.

The twin integrates absolute positions; a ground that moves is two more unknowns. What the package
says to be relative is the difference from the ground's motion, what it says to be absolute is not.
"""

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq, minimize_scalar

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

X1, V1, X2, V2, Y, W, SQUARE, C1, C2, CONTACT, WORK = range(11)  # unknowns of the twin


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


class Twin:
    """Equations of motion in the inertial frame, from the parameters and `physics` of each kind."""

    def __init__(self, system, law, shaken):
        p = self.p = dict(system.parameters)
        self.kind, self.law, self.shaken = system.kind, law, shaken
        self.damped = "m2" in p
        self.m1, self.k1, self.c1 = (p.get(a, p.get(b, 0.0)) for a, b in zip(
            ("m1", "k1", "c1"), "mkc", strict=True))  # fmt: skip
        self.m2, self.k2, self.c2 = (p.get(name, 0.0) for name in ("m2", "k2", "c2"))
        self.rest = p["V"] + p["C"] if self.kind == "ssul" else p.get("D", 0.0)
        self.weight = p.get("g", 0.0) if self.kind == "ball" else 0.0

    def walls(self, x1, u):
        """Return (depth, sign) of each wall; the sign is of the force on what is struck."""
        p, kind = self.p, self.kind
        if kind == "ssul":
            return [(p["V"] - u, 1.0)]
        if kind == "ssbl":
            return [(-u, 1.0), (u - p["D"] - p["C"], -1.0)]
        if kind in ("ssvi-b", "ssvi-c"):
            return [(u - p["D"] - p["C"], -1.0)]
        if kind == "ball":
            return [(-x1, 1.0)]
        far = [(-x1 - p["C_2"], 1.0)] if kind == "oscillator-2" else []
        return [(x1 - p["C"], -1.0), *far] if kind.startswith("oscillator") else []

    def elastic(self, z):
        c = LAWS[self.law]
        if self.law == "restitution" or z <= 0.0:
            return 0.0
        return c["kc"] * z if "kc" in c else c["K"] * z ** c.get("exponent", 1.5)

    def held(self, z):
        """Return the elastic energy of a contact."""
        c = LAWS[self.law]
        return self.elastic(z) * max(z, 0.0) / ((1.0 if "kc" in c else c.get("exponent", 1.5)) + 1)

    def push(self, z, rate):
        """Return the force of a wall."""
        c, elastic = LAWS[self.law], self.elastic(z)
        if z <= 0.0:
            return 0.0
        if "kc" in c:
            return max(0.0, elastic + c["cc"] * rate)
        return elastic * max(0.0, 1.0 + c.get("hunt_crossley", 0.0) * rate)

    def load(self, t):
        """Return the force, or the ground's acceleration."""
        pulse = PULSE * math.sin(math.pi * t / LENGTH) if t < LENGTH else 0.0
        return pulse + TONE * math.cos(OMEGA * t + PHASE)

    def at(self, t, y):
        """Return (A1, A2, contact forces, power lost in contacts)."""
        x1, v1 = y[X1] - y[Y], y[V1] - y[W]
        u, s = y[X2] - y[X1], y[V2] - y[V1]
        force = 0.0 if self.shaken else self.load(t)
        on1, on2 = force - self.k1 * x1 - self.c1 * v1 - self.m1 * self.weight, 0.0
        if self.damped:
            pull = self.k2 * (u - self.rest) + self.c2 * s
            on1, on2 = on1 + pull, -pull
        forces, lost, struck = [], 0.0, s if self.damped else v1
        for z, sign in self.walls(x1, u):
            push = self.push(z, -sign * struck)
            forces.append(push)
            lost += (push - self.elastic(z)) * -sign * struck
            on1, on2 = (on1 - sign * push, on2 + sign * push) if self.damped else (
                on1 + sign * push, 0.0)  # fmt: skip
        return on1 / self.m1, on2 / self.m2 if self.damped else 0.0, forces, lost

    def slopes(self, t, y):
        a1, a2, _, lost = self.at(t, y)
        load, v1, v2 = self.load(t), y[V1] - y[W], y[V2] - y[W]
        ground = load if self.shaken else 0.0
        into = -ground * (self.m1 * v1 + self.m2 * v2) if self.shaken else load * v1
        return [
            y[V1], a1, y[V2], a2, y[W], ground, (y[X1] - y[Y]) ** 2,
            self.c1 * v1**2, self.c2 * (y[V2] - y[V1]) ** 2, lost, into,
        ]  # fmt: skip

    def energies(self, y):
        """Return (E1, E2, all that is stored), velocities relative to the ground."""
        x1, v1, x2, v2 = y[X1] - y[Y], y[V1] - y[W], y[X2] - y[Y], y[V2] - y[W]
        e1 = 0.5 * (self.m1 * v1**2 + self.k1 * x1**2)
        e2 = 0.5 * (self.m2 * v2**2 + self.k2 * (x2 - self.rest) ** 2)
        joint = 0.5 * (self.m2 * v2**2 + self.k2 * (x2 - x1 - self.rest) ** 2)
        contacts = sum(self.held(z) for z, _ in self.walls(x1, x2 - x1))
        return e1, e2, e1 + joint + contacts + self.m1 * self.weight * x1

    def spans(self):
        """Return the solutions, cut at kinks and rigid impacts, and the impulses of these."""
        y, t, solutions, impulses = np.zeros(11), 0.0, [], []
        y[X2], y[X1] = self.rest, HEIGHT if self.kind == "ball" else 0.0
        self.begin = self.energies(y)[2]
        rigid = self.law == "restitution"
        touches = [
            lambda t, y, i=i: self.walls(y[X1] - y[Y], y[X2] - y[X1])[i][0]
            for i in range(len(self.walls(0.0, 0.0)) if rigid else 0)
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
                impulses.append(self.rebound(y))
        return solutions, impulses

    def rebound(self, y):
        """Let a rigid impact turn the relative speed; return its impulse [N s]."""
        mass = 1.0 / (1.0 / self.m1 + 1.0 / self.m2) if self.damped else self.m1
        struck = y[V2] - y[V1] if self.damped else y[V1] - y[W]
        change, e = -(1.0 + LAWS["restitution"]["e"]) * struck, LAWS["restitution"]["e"]
        y[CONTACT] += 0.5 * mass * struck**2 * (1.0 - e**2)
        y[V1] += -mass * change / self.m1 if self.damped else change
        y[V2] += mass * change / self.m2 if self.damped else 0.0
        return mass * abs(change)


class Course:
    """What a twin sees: each size over time, between the steps of its solutions, too."""

    def __init__(self, twin):
        self.twin = twin
        self.solutions, self.impulses = twin.spans()
        self.times = [
            np.interp(np.linspace(0, 1, 8 * len(run.t)), np.linspace(0, 1, len(run.t)), run.t)
            for run in self.solutions
        ]
        self.states = [run.sol(t) for t, run in zip(self.times, self.solutions, strict=True)]

    def values(self, size):
        """Return a size (t, y) at the times of each solution."""
        return [
            np.array([size(t, y) for t, y in zip(times, states.T, strict=True)])
            for times, states in zip(self.times, self.states, strict=True)
        ]

    def largest(self, size):
        """Return the largest absolute value of a size and its time."""
        best = (-1.0, 0.0)
        for run, times, values in zip(
            self.solutions, self.times, map(np.abs, self.values(size)), strict=True
        ):
            i = int(values.argmax())
            best = max(best, (float(values[i]), float(times[i])))
            ends = times[max(i - 1, 0)], times[min(i + 1, len(times) - 1)]
            peak = minimize_scalar(
                lambda t, run=run: -abs(size(t, run.sol(t))), bounds=ends, method="bounded",
                options={"xatol": 1e-10},
            )  # fmt: skip
            best = max(best, (-float(peak.fun), float(peak.x)))
        return best

    def last_above(self, size, level):
        """Return the last time at which a size exceeds a level; NaN if it does at the end."""
        for run, times, values in zip(
            self.solutions[::-1], self.times[::-1], self.values(size)[::-1], strict=True
        ):
            above = np.flatnonzero(values > level)
            if above.size and above[-1] == len(values) - 1:
                return math.nan if run is self.solutions[-1] else float(times[-1])
            if above.size:
                ends = times[above[-1]], times[above[-1] + 1]
                return brentq(lambda t, run=run: size(t, run.sol(t)) - level, *ends, xtol=1e-13)
        return 0.0

    def state(self, t):
        run = next(run for run in self.solutions if t <= run.t[-1])
        return run.sol(t)

    def is_beyond_a_rigid_wall(self):
        """Return True if the twin has missed a rigid impact: after too many, which end in rest."""
        if self.twin.law != "restitution":
            return False
        depths = self.values(lambda t, y: max(self.twin.walls(y[X1] - y[Y], y[X2] - y[X1]))[0])
        return max(map(np.max, depths)) > 1e-8

    def touches(self):
        """Return how often a wall is touched."""
        if self.twin.law == "restitution":
            return len(self.impulses)
        depths = [
            np.concatenate(self.values(
                lambda t, y, i=i: self.twin.walls(y[X1] - y[Y], y[X2] - y[X1])[i][0]))
            for i in range(len(self.twin.walls(0.0, 0.0)))
        ]  # fmt: skip
        return sum(int(np.count_nonzero((z[:-1] <= 0.0) & (z[1:] > 0.0))) for z in depths)


def numbers_of(course):
    """Return the numbers of a response history by name."""
    twin, end = course.twin, course.solutions[-1].y[:, -1]
    most, when = course.largest(lambda t, y: twin.energies(y)[0])
    numbers = {
        "E1max": most,
        "x1_max": course.largest(lambda t, y: y[X1] - y[Y])[0],
        "v1_max": course.largest(lambda t, y: y[V1] - y[W])[0],
        "x1_rms": math.sqrt(end[SQUARE] / DURATION),
        "energy_in": twin.begin + end[WORK],
    }
    walls = len(twin.walls(0.0, 0.0))
    for share in SHARES:
        numbers[f"last_{100 * share:g}"] = course.last_above(
            lambda t, y: twin.energies(y)[0], share * most
        )
    if twin.shaken:
        numbers["drift_max"] = numbers["x1_max"]
    if twin.law != "restitution" or not walls:
        numbers["a1_max"] = course.largest(lambda t, y: twin.at(t, y)[0])[0]
    if walls:
        numbers["impact_count"] = course.touches()
        numbers["share_contact"] = end[CONTACT] / numbers["energy_in"]
        if twin.law == "restitution":
            numbers["impulse_max"] = max(course.impulses)
        else:
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
    course = Course(Twin(system, law, shaken))
    wanted = numbers_of(course)
    assert not course.is_beyond_a_rigid_wall()
    have = {name for name, value in fall.numbers.items() if math.isfinite(value)}
    assert have - {"balance"} == set(wanted)
    for name, value in wanted.items():
        assert fall.numbers[name] == pytest.approx(value, rel=PRECISE), name
    assert fall.numbers["balance"] < 1e-9
    states = np.array([course.state(t) for t in fall.time])
    twin = course.twin
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
