"""The motion of a floor in a response history, as a record whose response spectrum is taken."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any, NamedTuple, Protocol

import numpy as np

from nlds_vines.errors import RequestError, choice, shown
from nlds_vines.model.loads.record import Record

LEAST_SAMPLES = 8  # steps of a history in a contact; then lines miss 1 % of its impulse
COARSER = 2.0  # largest ratio of steps to those of a number of samples: a record divides them
ROUND = 64  # numbers of samples are advised in whole multiples, above what is needed
SUFFIX = ".a"  # of an absolute acceleration, in `of`


class Histories(Protocol):
    """What of `ResponseHistories` is needed here."""

    request: Any
    results: Mapping[str, Any]


class FloorMotion(NamedTuple):
    """An absolute acceleration between impacts, and the jumps of its velocity at rigid walls."""

    record: Record
    instants: np.ndarray  # (impacts,) [s], ascending
    jumps: np.ndarray  # (impacts,) [m/s]

    def with_pulses(self, width: float) -> tuple[np.ndarray, np.ndarray]:
        """Return times [s] and accelerations [m/s^2] with a triangle for each jump.

        width: of a triangle [s], about its instant. Jumps less than that apart are one triangle.
        """
        times, values = np.array(self.record.times), np.array(self.record.values)
        instants, jumps = joined(self.instants, self.jumps, 2.0 * width)
        if not len(instants):
            return times, values
        middles = np.maximum(instants, times[0] + width)
        pulses = np.column_stack([middles - 0.5 * width, middles, middles + 0.5 * width])
        bases = np.interp(pulses, times, values)
        bases[:, 1] += 2.0 * jumps / width
        nearest = np.abs(times[:, None] - middles).min(axis=1)
        is_kept = nearest > 0.6 * width
        is_kept[0] = True
        times = np.concatenate([times[is_kept], pulses.ravel()])
        values = np.concatenate([values[is_kept], bases.ravel()])
        order = np.argsort(times, kind="stable")
        return times[order], values[order]


def joined(instants: np.ndarray, jumps: np.ndarray, apart: float) -> tuple[np.ndarray, np.ndarray]:
    """Return instants that are at least `apart` from each other, with the sums of the jumps."""
    times: list[float] = []
    sums: list[float] = []
    for instant, jump in zip(instants.tolist(), jumps.tolist(), strict=True):
        if times and instant < times[-1] + apart:
            sums[-1] += jump
        else:
            times.append(instant)
            sums.append(jump)
    return np.array(times), np.array(sums)


def floor_motion(histories: Any, of: str, system: str) -> FloorMotion:
    """Return the motion of a floor in `ResponseHistories`, after all checks.

    of: roof.a or roof; system: name of one, "" if there is only one with dampers.
    """
    results = getattr(histories, "results", None)
    if not isinstance(results, Mapping):
        raise RequestError(
            f"of = {shown(of)} names an acceleration of response histories, as nv.response_history "
            "returns them for single loads; a suite and a scan have none"
        )
    if not system:
        dampened = [one.name for one in histories.request.systems if one.damper_names]
        names = dampened if len(results) > 1 else [*results]
        if len(names) != 1:
            raise RequestError(f"name one system with system=, of {[*results]}")
        system = names[0]
    history = results[choice("system", system, results)]
    (described,) = [one for one in histories.request.systems if one.name == system]
    place = choice("floor", of.removesuffix(SUFFIX), history.a)
    instants, jumps = jumps_of(described, place, history.impacts)
    refuse_short_contacts(history, histories.request.samples)
    record = Record.of(
        {
            "times": history.time.tolist(), "values": history.a[place].tolist(), "unit": "m/s^2",
            "uneven": True, "source": f"{system}: {place}{SUFFIX}",
        }
    )  # fmt: skip
    return FloorMotion(record, instants, jumps)


def jumps_of(system: Any, place: str, impacts: Any) -> tuple[np.ndarray, np.ndarray]:
    """Return the instants [s] of rigid impacts and the jumps [m/s] of a displacement's velocity."""
    if not len(impacts):
        return np.zeros(0), np.zeros(0)
    row, _ = system.displacement(place)
    host = system.host
    size = len(host.dofs)
    is_rigid = np.isinf(impacts["force"])
    instants = impacts["touch"][is_rigid]
    jumps = np.zeros(len(instants))
    for i, number in enumerate(np.flatnonzero(is_rigid)):
        damper = system.dampers[system.damper_names.index(str(impacts["damper"][number]))]
        link = np.zeros(size)
        for end, sign in zip(damper.ends, (1.0, -1.0), strict=False):
            if end in host.dofs:
                link[host.dofs.index(end)] += sign
        # a wall on side "+" pushes so that the spring is lengthened again: against r = w x
        side = 1.0 if impacts["wall"][number] == "+" else -1.0
        answer = np.linalg.solve(host.M, link)
        jumps[i] = -side * impacts["impulse"][number] * float(row[:size] @ answer)
    order = np.argsort(instants, kind="stable")
    return instants[order], jumps[order]


def refuse_short_contacts(history: Any, samples: int) -> None:
    """Raise `RequestError` if the histories have too few samples in the shortest contact."""
    if not len(history.impacts):
        return
    is_soft = np.isfinite(history.impacts["force"])
    lengths = history.impacts["release"][is_soft] - history.impacts["touch"][is_soft]
    step = float(np.diff(history.time).max())
    shortest = float(np.min(lengths[np.isfinite(lengths)], initial=math.inf))
    if shortest < LEAST_SAMPLES * step:
        needed = COARSER * samples * LEAST_SAMPLES * step / shortest
        advised = ROUND * math.ceil(needed / ROUND)
        raise RequestError(
            f"a contact lasts {shortest:.3g} s, a step of the history {step:.3g} s: its force is "
            f"not seen; give the history sampling={{'samples': {advised}}}"
        )
