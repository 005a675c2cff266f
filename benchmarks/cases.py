"""The pieces of work that `benchmarks.speed` times, called by public names alone.

    python benchmarks/cases.py         does what lines of standard input name, with the package that
                                       PYTHONPATH leads to

So the same work is done by checkouts of different ages. If a public name changes, `NAMES` gets the
new one before the old one, and nothing else here changes.

Orbits never repeat: settled ones repeat to the bit, and what follows is copied, not computed. They
begin in random states and end before they settle, 100 periods later, or go on irregularly.
"""

from __future__ import annotations

import json
import math
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import reduce
from pathlib import Path
from typing import Any

import numpy as np

import nlds_vines as nv

NAMES = {
    "system": ("load_system",),
    "frame": ("shear_frame",),
    "damper": ("Damper",),
    "wall": ("Wall",),
    "spring": ("Spring",),
    "host": ("Host",),
    "host system": ("System.from_host",),
    "scan request": ("load_scan",),
    "scan": ("scan",),
    "simulation": ("simulate",),
    "verdict": ("classify",),
    "branch": ("continue_branch",),
    "load": ("response_history",),
}
"""How each piece of work is called: the public names of all ages, the newest first."""

SECTIONS = ["section"]
ENERGIES = ["section", "energy"]
RESPONSES = ["section", "response"]
VERDICTS = ["regime", "lyapunov", "evidence"]

PERIODS = 100  # of an orbit from a random state; of Set 6, settled ones repeat after some 110
SETTLED_SOONER = 40  # of an impact oscillator, which repeats after some 60, or from rest
WINDOW = {"omega": {"start": 7.0, "stop": 7.8, "num": 41}}
"""Frequencies [rad/s] at which Set 6 has irregular orbits among regular ones."""
SAMPLES = 2000  # of a record of the ground
NEAR = 0.4  # gap of a damper on a frame over the amplitude of the roof without the damper
HERTZ: dict[str, Any] = {"K": 1e9}  # [N/m^1.5]

Work = Callable[[], Any]


def public(work: str) -> Any:
    """Return the public function for a piece of work, by the newest of its `NAMES`."""
    for name in NAMES[work]:
        try:
            return reduce(getattr, name.split("."), nv)
        except AttributeError:
            continue
    raise SystemExit(f"{work}: this package has none of the names {', '.join(NAMES[work])}")


# ---- systems -------------------------------------------------------------------------------------


def set6(omega: float = 6.28, **changes: Any) -> Any:
    """Return Set 6 with some parameters or the contact law changed."""
    return public("system")("ssul-set6", omega=omega, **changes)


def frame_of(storeys: int, gap: float = NEAR, sides: str = "+", **law: Any) -> Any:
    """Return a frame with a damper on its roof, near its first frequency.

    gap: that of the damper over the amplitude of the roof without it; law: that of its walls, by
    default a Hertz contact.
    """
    frame = public("frame")([1e4] * storeys, [8e6] * storeys, ratio=0.02)
    omega, force = 0.99 * float(frame.frequencies[0]), {"roof": 1e3}
    alone = float(np.abs(frame.frequency_response(omega, force=force)).max())
    m = 0.03 * 1e4 * storeys
    walls = [public("wall")(gap * alone, side, **(law or HERTZ)) for side in sides]
    k, c = 0.5 * m * omega**2, 0.05 * m * omega
    damper = public("damper")("damper", "roof", m=m, k=k, c=c, walls=walls)
    return public("host system")(frame, [damper], force=force, omega=omega)


def sink(amplitude: float, k: float = 0.0, gap: float = math.inf, **coefficients: float) -> Any:
    """Return a structure of 1 kg and 1 N/m with a sink of 0.05 kg on a nonlinear spring.

    All is relative to the sink's mass: the force, k and the spring's coefficients. With a gap there
    are two rigid walls.
    """
    m = 0.05
    walls = []
    if gap < math.inf:
        walls = [public("wall")(gap, side, law="restitution", e=0.7) for side in "+-"]
    spring = public("spring")(**{key: m * value for key, value in coefficients.items()})
    damper = public("damper")("nes", "x", m=m, k=m * k, c=0.2 * m, spring=spring, walls=walls)
    structure = public("host")([[1.0]], [[1.0]], [[0.0]], dofs=["x"])
    return public("host system")(structure, [damper], force={"x": m * amplitude}, omega=1.0)


# ---- work ----------------------------------------------------------------------------------------


def frequency(system: Any) -> float:
    """Return the frequency of a system's force [rad/s]."""
    if hasattr(system, "omega"):
        return float(system.omega)
    return float(system.parameters["omega"])


def orbits(system: Any, count: int, record: list[str] = SECTIONS, **sampling: Any) -> Work:
    """Return a function that follows `count` orbits from random states over `PERIODS`."""
    tables: dict[str, Any] = {
        "vary": {"omega": [frequency(system)]},
        "start": {"policy": "random", "count": count, "seed": 1},
        "sampling": {"transient": 0, "periods": PERIODS, **sampling},
        "record": record,
    }
    return lambda: public("scan")(system, quiet=True, threads=1, **tables)


def scanned(system: Any, vary: dict[str, Any], record: list[str], **sampling: int) -> Work:
    """Return a function that scans a system, and writes an archive that is deleted at once."""
    tables = {"vary": vary, "record": record, "sampling": sampling}
    return lambda: public("scan")(system, quiet=True, threads=1, **tables)


def noise() -> dict[str, Any]:
    """Return a record of the ground: noise under a smooth envelope, 0.01 s apart."""
    times = np.arange(SAMPLES) * 0.01
    values = np.random.default_rng(1).normal(size=SAMPLES)
    values *= np.sin(np.pi * times / times[-1])
    values *= 3.0 / np.abs(values).max()
    return {"times": times.tolist(), "values": values.tolist(), "unit": "m/s^2"}


def shaken(system: Any, times: int) -> Work:
    """Return a function that follows a system so many times through a record of the ground."""
    load = {"record": noise()}
    duration = 0.01 * SAMPLES

    def work() -> None:
        for _ in range(times):
            public("load")(system, load=load, duration=duration, quiet=True)

    return work


def branch(system: Any, low: float, high: float) -> Work:
    """Return a function that continues a periodic orbit along the frequency."""
    return lambda: public("branch")(system, "omega", (low, high), quiet=True)


def often(times: int, work: str, *words: Any, **options: Any) -> Work:
    """Return a function that does a piece of work so many times."""

    def calls() -> None:
        for _ in range(times):
            public(work)(*words, quiet=True, **options)

    return calls


def sampled(count: int) -> Work:
    """Return a function that follows Set 6 with four parameters drawn at random."""
    system = set6()
    rng = np.random.default_rng(0)
    samples = {
        name: system.parameters[name] * (1.0 + 0.05 * rng.normal(size=count))
        for name in ("k1", "k2", "C", "P")
    }
    tables = {"record": ENERGIES, "sampling": {"transient": 0, "periods": SETTLED_SOONER}}
    return lambda: public("scan")(system, samples=samples, quiet=True, threads=1, **tables)


def diagram() -> Work:
    """Return a function that computes the default diagram with its labels."""
    return lambda: public("scan")(quiet=True, threads=1)


def verdicts_of_frames() -> Work:
    """Return a function that labels the orbits of a frame at five frequencies."""
    system = frame_of(3)
    omega = {"values": (frequency(system) * np.linspace(0.95, 1.05, 5)).tolist()}
    return scanned(system, {"omega": omega}, VERDICTS, transient=200, periods=60)


def map_of_frames() -> Work:
    """Return a function that scans a frame over frequency and gap."""
    system = frame_of(3)
    omega = {"values": (frequency(system) * np.linspace(0.95, 1.05, 20)).tolist()}
    gap = {"start": 1e-3, "stop": 1e-2, "num": 5}
    axes = {"omega": omega, "damper.gap": gap}
    return scanned(system, axes, SECTIONS, transient=0, periods=PERIODS)


def branch_of_frames() -> Work:
    """Return a function that continues a periodic orbit of a frame around its first frequency."""
    system = frame_of(3)
    omega = frequency(system)
    return branch(system, 0.97 * omega, 1.03 * omega)


# ---- cases ---------------------------------------------------------------------------------------


Prepare = Callable[[], Work]


def preset(name: str, count: int, record: list[str] = SECTIONS, **changes: Any) -> Prepare:
    """Return a function that prepares orbits of a named system with changed parameters or law."""
    return lambda: orbits(public("system")(name, **changes), count, record)


def host(
    storeys: int, count: int, record: list[str] = SECTIONS, sides: str = "+", **law: Any
) -> Prepare:
    """Return a function that prepares orbits of a frame with one damper under a contact law."""
    return lambda: orbits(frame_of(storeys, sides=sides, **law), count, record)


GROUPS: dict[str, dict[str, Prepare]] = {
    "Set 6": {
        "set6": lambda: orbits(set6(), 1000),
        "set6-energies": lambda: orbits(set6(), 1000, ENERGIES),
        "set6-response": lambda: orbits(set6(), 200, RESPONSES),
        "set6-samples": lambda: sampled(1000),
        "set6-rk4": lambda: orbits(set6(), 20, method="rk4"),
    },
    "other presets and laws": {
        "tmd": preset("tmd", 1000, omega=6.28),
        "two-walls": preset("ssbl", 500, omega=6.28),
        "two-walls-energies": preset("ssbl", 500, ENERGIES, omega=6.28),
        "linear": lambda: orbits(set6(7.05, law="linear", kc=1e6, cc=1e3), 500),
        "restitution": lambda: orbits(set6(7.39, law="restitution", e=0.7), 1000),
        "power": lambda: orbits(set6(law="power", K=6e6, exponent=1.2), 100),
        "hunt-crossley": lambda: orbits(set6(7.39, hunt_crossley=0.3), 100),
        "soft": lambda: orbits(set6(K=1e5), 200),
        "pressed": lambda: orbits(set6(C=-0.01), 500),
        "bilinear-oscillator": preset("bilinear-oscillator", 1000),
        "hard-oscillator": preset("hard-oscillator", 1000, omega=2.2),
        "impact-oscillator": lambda: orbits(
            public("system")("impact-oscillator"), 2000, periods=SETTLED_SOONER
        ),
    },
    "hosts with a Hertz impact": {
        "host-1": host(1, 50),
        "host-3": host(3, 50),
        "host-5": host(5, 50),
        "host-10": host(10, 50),
        "host-20": host(20, 30),
    },
    "other records and laws of hosts": {
        "host-1-energies": host(1, 30, ENERGIES),
        "host-3-energies": host(3, 30, ENERGIES),
        "host-10-energies": host(10, 20, ENERGIES),
        "host-3-response": host(3, 30, RESPONSES),
        "host-3-two-walls": host(3, 50, sides="+-"),
        "host-3-linear": host(3, 30, law="linear", kc=1e7, cc=1e3),
        "host-3-restitution": host(3, 50, law="restitution", e=0.7),
        "host-3-power": host(3, 30, law="power", K=6e7, exponent=1.2),
        "host-3-hunt-crossley": host(3, 30, hunt_crossley=0.3, **HERTZ),
        "host-3-soft": host(3, 30, K=1e7),
    },
    "springs that are not linear": {
        "spring-cubic": lambda: orbits(sink(0.2, k3=4 / 3), 300),
        "spring-modulated": lambda: orbits(sink(0.35, k3=4 / 3), 300),
        "spring-bistable": lambda: orbits(sink(0.4, k=-0.3, k3=1.0), 300),
        "spring-quintic": lambda: orbits(sink(0.4, k5=1.0), 300),
        "spring-walls": lambda: orbits(sink(0.35, k3=4 / 3, gap=0.6), 100),
        "spring-energies": lambda: orbits(sink(0.35, k3=4 / 3), 100, ENERGIES),
    },
    "verdicts and branches": {
        "diagram": diagram,
        "verdicts": lambda: scanned(set6(), WINDOW, VERDICTS, transient=600, periods=120),
        "branch": lambda: branch(set6(), 5.0, 9.0),
        "host-3-verdicts": verdicts_of_frames,
        "host-3-branch": branch_of_frames,
        "host-3-map": map_of_frames,
    },
    "a load of 2,000 samples": {
        "load": lambda: shaken(set6(), 3),
        "host-3-load": lambda: shaken(frame_of(3), 3),
    },
    "calls from Python": {
        "simulate": lambda: often(300, "simulation", set6(), 1),
        "classify": lambda: often(50, "verdict", set6(5.5)),
        "blow": lambda: often(20, "load", "tmd", impulse=300.0, duration=10.0),
    },
}
"""What prepares each piece of work, by group of rows and name."""

CASES = {name: prepare for group in GROUPS.values() for name, prepare in group.items()}


# ---- times ---------------------------------------------------------------------------------------


def spent(work: Work) -> float:
    """Return the CPU time of a piece of work [s], that of all threads."""
    began = time.process_time()
    work()
    return time.process_time() - began


@contextmanager
def in_kernels() -> Iterator[list[float]]:
    """Collect the CPU times [s] of the calls of compiled kernels from Python."""
    from numba.core import registry

    dispatcher: Any = registry.CPUDispatcher
    times: list[float] = []
    call = dispatcher.__call__

    def timed(kernel: Any, *arguments: Any, **options: Any) -> Any:
        began = time.thread_time()
        try:
            return call(kernel, *arguments, **options)
        finally:
            times.append(time.thread_time() - began)

    dispatcher.__call__ = timed
    try:
        yield times
    finally:
        del dispatcher.__call__  # the base class has the original


def repeating(result: Any) -> str:
    """Return in words how many orbits of a scan repeat to the bit; "" if none does."""
    with result.read() as archive:
        if "section" not in archive:
            return ""
        sections = np.asarray(archive["section"])
    sections = sections.reshape(-1, *sections.shape[-2:])
    count = sum(len(np.unique(section, axis=0)) < len(section) for section in sections)
    return f"{count} of {len(sections)} orbits repeat" if count else ""


def serve() -> None:
    """Do the work that lines of standard input name; print what each took and in kernels [s]."""
    prepared: dict[str, Work] = {}
    for line in sys.stdin:
        name = line.strip()
        note = ""
        if name not in prepared:
            prepared[name] = CASES[name]()
            result = prepared[name]()  # compiles
            if hasattr(result, "read"):
                note = repeating(result)
        with in_kernels() as times:
            seconds = spent(prepared[name])
        print(json.dumps([seconds, sum(times), note]), flush=True)


if __name__ == "__main__":
    source = Path(nv.__file__).resolve()
    print(source.parents[1], flush=True)
    serve()
