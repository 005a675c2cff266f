"""Random systems of every kind under every law, compared with `twin_of_laws` in every record.

The twin is sent anew from each section that the package reports, so that chaos is examined as
sharply as a steady state; what it notes is put together. An error is measured in the scales of its
orbit, over how much a nudge of the start grows in a period.

Some are under a load of segments in which P exp(-b t) cos(omega t + phi), a constant, and blows at
their ends act: all differ from one segment to the next, so that the force jumps.
"""

from __future__ import annotations

import math
from dataclasses import replace
from types import SimpleNamespace
from typing import Any, NamedTuple

import numpy as np
from flights import LOAD, fly, longest_cell
from twin_of_laws import COS, ONE, SIN, V1, ChatterError, Course, Law, Model, Wall

from nlds_vines.engine.simulation import simulate
from nlds_vines.model.parameters import DAMPER, FORCING, STRUCTURE
from nlds_vines.model.scenes import SCENES, Scene
from nlds_vines.model.system import System

LOADED = Scene(
    kind="loaded",
    meaning="a damper in a cage on a structure under its weight",
    parameter_names=(*STRUCTURE, *DAMPER, "g", "C", "D", *FORCING),
    rest=lambda p: 0.0 * p["C"],
    gap_near=lambda p: p["D"],
    gap_far=lambda p: p["C"],
    load=lambda p: p["g"],
    obstacle=lambda p: {"left": -p["D"], "right": p["C"]},
    struck={"near": "left", "far": "right"},
)
"""A scene of one's own with a damper and a constant load."""

KINDS = (
    "ssul", "ball", "ssbl", "oscillator", "loaded", "ssvi-b", "oscillator-2", "ssvi-c", "tmd",
    "none",
)  # fmt: skip
NAMES = (
    "hertz", "hunt-crossley", "linear", "power", "restitution", "dashpot", "damped power",
    "kelvin-voigt", "integer power",
)  # fmt: skip
PERIODS, STOPS, NUDGE = 2, 3, 1e-7
RECORD = ("section", "trajectory", "impacts", "energy", "peak", "response", "clearance")
TOO_SENSITIVE = 1e6  # growth of a nudge beyond which counts cannot be compared


class Case(NamedTuple):
    """A system, its twin's model, and a start."""

    system: System
    model: Model
    start: np.ndarray


def case_of(i: int) -> Case:
    """Return random case i: kinds take turns, and laws with each kind."""
    rng = np.random.default_rng((27, i))
    kind, name = KINDS[i % len(KINDS)], NAMES[(i // len(KINDS) + i) % len(NAMES)]
    d = lambda low, high: float(10.0 ** rng.uniform(low, high))  # noqa: E731  # decades
    numbers = {
        "m1": 1.0, "k1": d(-0.7, 0.7), "c1": d(-3, -0.5), "P": d(-1, 0.5), "omega": d(-0.4, 0.5),
        "m2": d(-1.3, -0.3), "C": d(-1.5, 0.3), "D": d(-1.5, 0.3), "L": d(-1, 0), "V": 0.3,
        "g": d(-0.5, 1.0), "C_2": d(-1.5, 0.3),
    }  # fmt: skip
    numbers |= {"k2": numbers["m2"] * d(-1, 0.5), "c2": numbers["m2"] * d(-3, -0.3)}
    numbers |= {"m": 1.0, "k": numbers["k1"], "c": numbers["c1"], "Y": d(-1.5, 0.0)}
    mass = 1.0 if kind in ("ball", "oscillator", "oscillator-2") else numbers["m2"]
    law = law_of(name, mass, numbers["omega"], rng)
    scene = LOADED if kind == "loaded" else SCENES[kind]
    parameters = {key: numbers[key] for key in scene.parameter_names}
    constants = law.constants if scene.walls else {"law": "hertz"}
    name = constants.pop("law")
    system = System(kind, parameters | constants, law=name)
    model = model_of(kind, numbers, law)
    x1, v1 = rng.normal(0, 0.3), rng.normal(0, 1.0)
    start = np.array([x1, v1])
    if kind == "ball":
        start = np.array([abs(x1) + 0.1, v1])
    lows = [w.place for w in model.walls if w.sign < 0]
    highs = [w.place for w in model.walls if w.sign > 0]
    if model.m2 is None:
        start[0] = min(start[0], 0.9 * min(highs, default=9))
        start[0] = max(start[0], 0.9 * max(lows, default=-9))
    else:
        low = max([*lows, model.limit, model.rest - 0.5])
        high = min([*highs, model.rest + 0.5])
        start = np.array([x1, v1, x1 + rng.uniform(low, high), v1 + rng.normal(0, 1.0)])
    return Case(system, model, start)


def law_of(name: str, mass: float, omega: float, rng: np.random.Generator) -> Law:
    """Return a law whose contacts last from most of a period to a hundredth of it."""
    fast = omega * 10.0 ** rng.uniform(0.5, 2.5)  # [1/s], of a contact 0.1 m deep
    n = {"power": rng.uniform(1.05, 3.0), "damped power": 2.0}.get(name, 1.5)
    n = float(rng.integers(1, 4)) if name == "integer power" else n
    K, kc = float(mass * fast**2 * 0.1 ** (1.0 - n)), float(mass * fast**2)
    a = float(10.0 ** rng.uniform(-1, 1)) if name in ("hunt-crossley", "damped power") else 0.0
    if name in ("hertz", "hunt-crossley"):
        return Law("hertz", K=K, a=a)
    if name in ("power", "damped power", "integer power"):
        return Law("power", K=K, n=n, a=a)
    if name == "restitution":
        return Law("restitution", e=float(rng.uniform(0.4, 1.0)))
    cc = float(mass * fast * rng.uniform(0.05, 1.0)) if name != "linear" else 0.0
    return Law("kelvin-voigt" if name == "kelvin-voigt" else "linear", kc=kc, cc=cc)


def model_of(kind: str, p: dict[str, float], law: Law) -> Model:
    """Return the twin's model: eq. (5) with the places of `physics`, x2 counted as in the paper."""
    one = p["m1"], p["k1"], p["c1"], p["P"], p["omega"]
    joint = {"m2": p["m2"], "k2": p["k2"], "c2": p["c2"]}
    low, high = (lambda place: Wall(0, -1.0, place, law)), (lambda place: Wall(1, 1.0, place, law))
    match kind:
        case "none":
            return Model(*one)
        case "tmd":
            return Model(*one, **joint)
        case "ssul":
            return Model(*one, **joint, rest=p["V"] + p["C"], walls=(low(p["V"]),))
        case "ssbl":
            return Model(*one, **joint, rest=p["D"], walls=(low(0.0), high(p["D"] + p["C"])))
        case "ssvi-b" | "ssvi-c":
            limit = 0.0 if kind == "ssvi-b" else -p["L"]
            walls = (high(p["D"] + p["C"]),)
            return Model(*one, **joint, rest=p["D"], walls=walls, limit=limit)
        case "loaded":
            return Model(*one, p["g"], **joint, walls=(low(-p["D"]), high(p["C"])))
        case "ball":
            P = p["m"] * p["Y"] * p["omega"] ** 2
            return Model(p["m"], 0.0, 0.0, P, p["omega"], -p["g"], walls=(Wall(1, -1.0, 0.0, law),))
    stops = (Wall(0, 1.0, p["C"], law),)
    if kind == "oscillator-2":
        stops += (Wall(1, -1.0, -p["C_2"], law),)
    return Model(p["m"], p["k"], p["c"], p["P"], p["omega"], walls=stops)


def course_of(case: Case, sections: np.ndarray, nudge: np.ndarray | float = 0.0) -> Course:
    """Return the twin's course, sent from each section anew."""
    course = Course(case.model, noting=np.all(nudge == 0.0))
    for n, start in enumerate([case.start, *sections[:-1]]):
        course.period(start + nudge, n, STOPS)
    return course


def errors_of(
    case: Case, tolerance: float, method: dict[str, Any] | None = None
) -> dict[str, float]:
    """Return the errors of all that is recorded of a case, by name, and "let go" as a count.

    What cannot be compared is {"chatter": 1} or {"sensitive": growth}; what differs in number is
    {"different": 1}.
    """
    system, model = case.system, case.model
    record = [name for name in RECORD if system.scene.walls or name not in ("impacts", "clearance")]
    options = {"tolerance": tolerance} if method is None else method
    orbit = simulate(system, PERIODS, start=case.start, record=record, samples=STOPS, **options)
    assert (orbit.section == orbit.trajectory[STOPS - 1 :: STOPS]).all()
    wide = np.abs(np.vstack([case.start, orbit.trajectory])).max(axis=0)
    seen, scales, errors = compare_states(
        lambda nudge: course_of(case, orbit.section, nudge), orbit.trajectory, wide
    )
    if seen is None:
        return errors
    length, speed, growth = scales
    E = model.energies(np.array([length, speed, length, speed, 0, 0, 0]))
    names = ["E1max", "E2max"][: 1 if model.m2 is None else 2]
    for i, name in enumerate(names):
        for value in (getattr(orbit, name), getattr(orbit, name.replace("max", "peak"))):
            errors[name] = max(errors.get(name, 0.0), abs(value - seen.tops[i]) / E[i] / growth)
    if system.scene.walls:
        compare_impacts(orbit, seen, scales, errors)
    compare_response(orbit, seen, model, growth, errors)
    errors["let go"], errors["pushes again"] = float(seen.lets_go), float(seen.pushes_again)
    return errors


def compare_states(follow: Any, states: np.ndarray, wide: np.ndarray) -> Any:
    """Return a course, the scales (length, speed, growth of a nudge), and the errors of states.

    `follow` gives the course of a nudge; `wide` has the largest of each number of the states. The
    course is None where the errors say why nothing can be compared.
    """
    scale = np.array([wide[::2].max(), wide[1::2].max()] * (len(wide) // 2))
    try:
        seen, near = follow(0.0), follow(NUDGE * scale)
    except ChatterError:
        return None, None, {"chatter": 1.0}
    true = np.array(seen.states)
    growth = max(1.0, float(np.abs((np.array(near.states) - true) / scale).max()) / NUDGE)
    if growth > TOO_SENSITIVE:
        return None, None, {"sensitive": growth}
    errors = {"state": float(np.abs((states - true) / scale).max()) / growth}
    return seen, (scale[0], scale[1], growth), errors


def compare_impacts(orbit: Any, seen: Course, scales: Any, errors: dict[str, float]) -> None:
    """Add errors of impacts, the clearance and violations."""
    length, speed, growth = scales
    rows, true = orbit.impacts, seen.impacts
    names = list(orbit.system.scene.struck.values())
    walls = [
        list(orbit.system.scene.struck).index("near" if hit.wall == 0 else "far") for hit in true
    ]
    if [names[wall] for wall in walls] != rows["wall"].tolist():
        errors["different"] = 1.0
        return
    for row, hit in zip(rows, true, strict=True):
        off = {
            "touch": abs(row["touch"] - hit.touch) * hit.speed / length,
            "speed": abs(row["speed"] ** 2 - hit.speed**2) / speed**2,
        }
        if math.isnan(hit.release) != math.isnan(row["release"]):
            errors["different"] = 1.0
        elif not math.isnan(hit.release):
            off["release"] = abs(row["release"] - hit.release) * speed / length
            for name in ("depth", "force") if hit.depth > 0.0 else ():
                part = (hit.speed / speed) ** 2
                off[name] = abs(row[name] / getattr(hit, name) - 1.0) * part
            for body in range(1 if seen.model.m2 is None else 2):
                gain = abs(row[f"gain{body + 1}"] - hit.gains[body])
                off[f"gain{body + 1}"] = gain / max(seen.tops[body], 1e-12)
        for name, error in off.items():
            errors[name] = max(errors.get(name, 0.0), error / growth)
    if math.isfinite(orbit.clearance) != math.isfinite(seen.clearance):
        errors["different"] = 1.0
    elif math.isfinite(seen.clearance):
        errors["clearance"] = abs(orbit.clearance - seen.clearance) / length / growth
    if orbit.violation is not None:
        if orbit.violation.number != len(seen.passages):
            errors["different"] = 1.0
        elif seen.passages:
            errors["violated"] = abs(orbit.violation.depth - seen.worst) / length / growth


def compare_response(
    orbit: Any, seen: Course, model: Model, growth: float, errors: dict[str, float]
) -> None:
    """Add errors of the response: largest and rms values, powers."""
    time = PERIODS * 2.0 * math.pi / model.omega
    r, rms, c = orbit.response, np.sqrt(seen.integrals[:4] / time), seen.integrals / time
    pairs = {"x1_max": seen.tops[2], "v1_max": seen.tops[3], "a1_max": seen.tops[4]}
    pairs |= {"stroke_max": seen.tops[5], "x1_rms": rms[0], "v1_rms": rms[1], "a1_rms": rms[2]}
    pairs |= {"stroke_rms": rms[3]}
    for name, value in pairs.items():
        if name in r:
            errors[name] = abs(float(r[name]) - value) / value / growth
    power = model.c1 * c[1] + abs(c[6]) + abs(c[5]) + 1e-12
    pairs = {"power_c1": model.c1 * c[1], "power_c2": model.c2 * c[4], "power_in": c[6]}
    if any(law.name != "restitution" for law in orbit.system.scene.laws):
        pairs |= {"power_contact": c[5]}
        most = np.array([seen.forces[wall.which] for wall in model.walls])
        if "force_max" in r and most.max() > 0.0:
            off = np.abs(np.atleast_1d(r["force_max"]) - most).max()
            errors["force_max"] = float(off) / most.max() / growth
    for name, value in pairs.items():
        if name in r:
            errors[name] = abs(float(r[name]) - value) / power / growth


def worst_of(errors: dict[str, float]) -> float:
    """Return the largest of the errors."""
    return max(value for name, value in errors.items() if name not in ("let go", "pushes again"))


def allowed(tolerance: float) -> float:
    """Return the bound of errors: five tolerances of an impact, and the error of largest values."""
    return 5.0 * tolerance + 1e-10


# ---- under loads ---------------------------------------------------------------------------------

MOST_SPANS = 400  # of a segment: a contact that rests takes endless steps of the twin
LOAD_RECORD = ("states", "work", "impacts", "energy", "response", "clearance")


class Segment(NamedTuple):
    """A part of a load, and the velocity that the structure is given at its end."""

    time: float  # [s]
    P: float  # [N]
    b: float  # [1/s]
    omega: float  # [rad/s]
    phi: float
    constant: float  # [N]
    blow: float  # [m/s]


def segments_of(i: int, case: Case) -> list[Segment]:
    """Return the random load of a case, about two of its periods long."""
    rng, T = np.random.default_rng((31, i)), 2.0 * math.pi / case.model.omega
    count = int(rng.integers(2, 6))
    rates = np.sqrt(max(case.model.k1, 0.1)) * 10.0 ** rng.uniform(-0.5, 0.4, count)
    size = abs(case.model.P) + 0.1
    return [
        Segment(
            float(T * rng.uniform(0.1, 0.7)),
            float(size * rng.normal()),
            float(rates[k] * rng.uniform(0, 1.0)),
            float(rates[k]),
            float(rng.uniform(0, 2 * math.pi)),
            float(size * rng.normal(0, 0.5) * (rng.random() < 0.5)),
            float(rng.normal(0, 0.5) * (rng.random() < 0.4)),
        )
        for k in range(count)
    ]


def load_of(case: Case, segments: list[Segment], rng: np.random.Generator) -> SimpleNamespace:
    """Return the load in cells of different lengths, and the numbers of the segments' ends."""
    longest = longest_cell(case.system)
    edges, rows, jumps, ends = [0.0], [], [0.0], [0]
    for one in segments:
        count = math.ceil(one.time / min(longest, 0.7 / abs(complex(one.b, one.omega))))
        shares = np.ones(count) if rng.random() < 0.5 else rng.uniform(0.2, 1.0, count + 3)
        lengths = one.time * shares / shares.sum()
        if lengths.max() > longest:
            lengths = np.full(count, one.time / count)
        rate, t = complex(-one.b, one.omega), 0.0
        for h in lengths:
            a = one.P * np.exp(1j * one.phi + rate * t)
            row = [(a * (rate * h) ** k / math.factorial(k)).real for k in range(15)]
            row[0] += one.constant
            rows.append(row)
            t += float(h)
            edges.append(edges[ends[-1]] + t)
            jumps.append(0.0)
        jumps[-1] = one.blow
        ends.append(len(rows))
    return SimpleNamespace(
        edges=np.array(edges), rows=np.array(rows), jumps=np.array(jumps), share=1.0, ends=ends
    )


def model_under(model: Model, one: Segment) -> Model:
    """Return the twin's model while a segment acts."""
    return replace(
        model, P=one.P, omega=one.omega, decay=one.b, load=model.load + one.constant / model.m1
    )


def course_under(case: Case, segments: list[Segment], starts: Any, nudge: Any = 0.0) -> Course:
    """Return the twin's course, sent anew from the state behind each blow; states before it."""
    course = Course(case.model, noting=bool(np.all(nudge == 0.0)))
    now = 0.0
    for one, start in zip(segments, starts, strict=False):
        model = course.model = model_under(case.model, one)
        course.h = 0.7 / max(float(np.abs(np.linalg.eigvals(model.free)).max()), abs(one.b) + 1e-9)
        w = np.zeros(7)
        w[: len(start)] = start + nudge
        w[COS], w[SIN], w[ONE] = math.cos(one.phi), math.sin(one.phi), 1.0
        course.enter(w)
        count, seen = len(course.impacts), 0.0
        for _ in range(MOST_SPANS):
            if seen >= one.time:
                break
            w, took = course.advance(w, one.time - seen, now + seen)
            seen = one.time if took >= one.time - seen else seen + took
            if len(course.impacts) - count > course.MOST:
                raise ChatterError
        else:
            raise ChatterError
        now += one.time
        course.states.append(w[: len(start)].copy())
    return course


def errors_under_load(i: int, tolerance: float) -> dict[str, float]:
    """Return the errors of a case under its load by name, as `errors_of`."""
    case = case_of(i)
    segments = segments_of(i, case)
    load = load_of(case, segments, np.random.default_rng((32, i)))
    flown = fly(case.system, load, start=case.start, record=LOAD_RECORD, tolerance=tolerance)
    blows = np.zeros((len(segments) + 1, len(case.start)))
    blows[1:, V1] = [one.blow for one in segments]
    behind = flown.states[load.ends]
    before = behind - blows
    wide = np.abs(np.vstack([flown.states, before])).max(axis=0)
    seen, scales, errors = compare_states(
        lambda nudge: course_under(case, segments, behind, nudge), before[1:], wide
    )
    if seen is None:
        return errors
    length, speed, growth = scales
    E = case.model.energies(np.array([length, speed, length, speed, 0, 0, 0]))
    last = case.model.energies(np.array([*behind[-1], 0, 0, 0, 0, 0][:7]))
    for k, name in enumerate(["E1max", "E2max"][: 1 if case.model.m2 is None else 2]):
        top = max(seen.tops[k], float(last[k]))
        errors[name] = abs(getattr(flown, name) - top) / E[k] / growth
    if case.system.scene.walls:
        compare_impacts(flown, seen, scales, errors)
    r, m = flown.response, case.model
    for name, top in zip(("x1_max", "v1_max", "a1_max", "stroke_max"), seen.tops[2:], strict=True):
        top = max(top, abs(behind[-1][V1])) if name == "v1_max" else top
        if name in r:
            errors[name] = abs(float(r[name]) - top) / top / growth
    gone = {"c1": m.c1 * seen.integrals[1], "c2": m.c2 * seen.integrals[4]}
    gone["contact"] = seen.integrals[5]
    total = sum(abs(value) for value in gone.values()) + float(E[0])
    if all(law.name != "restitution" for law in case.system.scene.laws) or not m.walls:
        for column, (name, value) in enumerate(gone.items(), start=LOAD + 1):
            errors[name] = abs(flown.work[-1, column] - value) / total / growth
    return errors
