"""GNU Octave's ode23s, the paper's own solver, as it comes and with the Jacobian.

Each orbit is a script that one `octave-cli` runs; the time it took is measured inside. The states
are those that ode23s returns for a given list of times.
"""

from __future__ import annotations

import math
import re
import shutil
import subprocess
import tempfile
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import numpy as np

from benchmarks.rivals.equation import constants
from benchmarks.rivals.rival import Flow, Rival, SolverFailure, Track, begun, flow_of
from nlds_vines.model.system import System

SETTINGS = (1e-3, 1e-4, 1e-5, 1e-6)  # without the Jacobian the last takes longest, for the same
PATIENCE, PATIENCE_FOR_PERIOD = 30.0, 5.0  # seconds until it is killed: to begin, and a period
_PROGRAM = "octave-cli"
_NAMES = "m1 k1 c1 m2 k2 c2 P omega K near far rest"

_SLOPE = """
function dy = slope (t, y)
  r = y(1) - y(3) + {rest};
  pull = {k2} * r + {c2} * (y(2) - y(4));{force}
  force = {P} * cos ({omega} * t) - {k1} * y(1) - {c1} * y(2) - pull;
  dy = [y(2); force / {m1}; y(4); pull / {m2}];
endfunction
"""
_FORCE = """
  z = {depth};
  if (z > 0)
    pull {sign}= {K} * z * sqrt (z);
  endif"""
_JACOBIAN = """
function J = jacobian (t, y)
  r = y(1) - y(3) + {rest};
  k = {k2};{stiffness}
  c = {c2};
  J = [0, 1, 0, 0; -({k1} + k) / {m1}, -({c1} + c) / {m1}, k / {m1}, c / {m1};
       0, 0, 0, 1; k / {m2}, c / {m2}, -k / {m2}, -c / {m2}];
endfunction
"""
_STIFFNESS = """
  z = {depth};
  if (z > 0)
    k += 1.5 * {K} * sqrt (z);
  endif"""
_RUN = """
options = odeset ("RelTol", {rtol}, "AbsTol", {atol}{jacobian});
times = [{times}];
start = [{start}];
begun = cputime ();
[t, y] = ode23s (@slope, times, start, options);
used = cputime () - begun;
if (numel (times) == 2)  # ode23s returns all of its steps
  y = y(end, :);
else
  y = y(2:end, :);
endif
printf ("seconds %.17g\\n", used);
printf ("%.17g %.17g %.17g %.17g\\n", y.');
"""


def _script(
    p: np.ndarray, start: np.ndarray, times: np.ndarray, rtol: float, jacobian: bool
) -> str:
    """Return the Octave script that follows an orbit and prints its states at the times."""
    values = {name: f"{value:.17g}" for name, value in zip(_NAMES.split(), p, strict=False)}
    depths = ("near", "r - {near}", "+"), ("far", "-r - {far}", "-")
    walls = [
        {"depth": depth.format(**values), "sign": sign, "K": values["K"]}
        for name, depth, sign in depths
        if math.isfinite(float(values[name]))
    ]
    force = "".join(_FORCE.format(**wall) for wall in walls)
    stiffness = "".join(_STIFFNESS.format(**wall) for wall in walls)
    run = _RUN.format(
        rtol=f"{rtol:.17g}",
        atol=f"{1e-3 * rtol:.17g}",
        jacobian=', "Jacobian", @jacobian' if jacobian else "",
        times=", ".join(f"{t:.17g}" for t in (0.0, *times.tolist())),
        start="; ".join(f"{value:.17g}" for value in start.tolist()),
    )
    functions = (
        _SLOPE.format(force=force, **values),
        _JACOBIAN.format(stiffness=stiffness, **values),
    )
    return "1;  # a script\n" + "".join(functions) + run


def _executed(script: str, limit: float) -> str:
    """Run a script and return what it printed."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "orbit.m"
        path.write_text(script, encoding="ascii")
        try:
            done = subprocess.run(
                [_PROGRAM, "--norc", "--quiet", str(path)],
                capture_output=True,
                text=True,
                timeout=limit,
                check=False,
                stdin=subprocess.DEVNULL,
            )
        except subprocess.TimeoutExpired:
            raise SolverFailure(f"ode23s was killed after {limit:g} s") from None
    if done.returncode != 0:
        words = done.stderr.strip().splitlines()
        raise SolverFailure(f"Octave failed: {words[0] if words else done.returncode}")
    return done.stdout


def _prepare(system: System, start: np.ndarray, *, jacobian: bool) -> Flow:
    p, state = constants(system), begun(system, start)

    def follow(rtol: float, times: np.ndarray, watched: bool) -> Track:
        limit = PATIENCE + PATIENCE_FOR_PERIOD * math.ceil(times[-1] / system.period)
        printed = _executed(_script(p, state, times, rtol, jacobian), limit)
        head, *rows = printed.splitlines()[-1 - len(times) :]
        words = head.split()
        if len(rows) < len(times) or words[0] != "seconds":
            raise SolverFailure("ode23s gave up before the end")
        states = np.array([[float(word) for word in row.split()] for row in rows])
        return Track(states, seconds=float(words[1]))

    return flow_of(system, state, follow)


@dataclass(frozen=True)
class OctaveRival(Rival):
    """A rival that needs no Python package but a program, which says its own version."""

    def available(self) -> bool:
        """Tell whether the program is installed."""
        return shutil.which(_PROGRAM) is not None

    def version(self) -> str:
        """Return the number in the first line of what Octave says of itself; or `unknown`."""
        try:
            said = subprocess.run(
                [_PROGRAM, "--version"], capture_output=True, text=True, check=True, timeout=60
            ).stdout
        except (OSError, subprocess.SubprocessError):
            return "unknown"
        number = re.search(r"\d+(\.\d+)+", said.partition("\n")[0])
        return number.group() if number else "unknown"


RIVALS = tuple(
    OctaveRival(
        name="Octave ode23s, Jacobian" if jacobian else "Octave ode23s",
        settings=SETTINGS if jacobian else SETTINGS[:-1],
        setting="rtol",
        events=False,
        compiled=False,
        needs="octave",
        prepare=partial(_prepare, jacobian=jacobian),
        order=2.0,
    )
    for jacobian in (False, True)
)
