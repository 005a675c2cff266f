"""Random systems under random loads, compared with `twin_of_laws`.

A load is made of segments in which P exp(-b t) cos(omega t + phi), a constant, and blows at its
ends act: all differ from one segment to the next, so that the force jumps. The twin is sent anew
from each state that the package reports at an end.
"""

from __future__ import annotations

import math
from dataclasses import replace
from types import SimpleNamespace
from typing import Any, NamedTuple

import numpy as np
from flights import LOAD, fly, longest_cell
from random_laws import Case, case_of, compare_impacts, compare_states
from twin_of_laws import COS, ONE, SIN, V1, ChatterError, Course, Model

MOST_SPANS = 400  # of a segment: a contact that rests takes endless steps of the twin
RECORD = ("states", "work", "impacts", "energy", "response", "clearance")


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


def course_of(case: Case, segments: list[Segment], starts: Any, nudge: Any = 0.0) -> Course:
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


def errors_of(i: int, tolerance: float) -> dict[str, float]:
    """Return errors by name, as `random_laws.errors_of`."""
    case = case_of(i)
    segments = segments_of(i, case)
    load = load_of(case, segments, np.random.default_rng((32, i)))
    flown = fly(case.system, load, start=case.start, record=RECORD, tolerance=tolerance)
    blows = np.zeros((len(segments) + 1, len(case.start)))
    blows[1:, V1] = [one.blow for one in segments]
    behind = flown.states[load.ends]
    before = behind - blows
    wide = np.abs(np.vstack([flown.states, before])).max(axis=0)
    seen, scales, errors = compare_states(
        lambda nudge: course_of(case, segments, behind, nudge), before[1:], wide
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
