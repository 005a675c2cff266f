"""The verdict on the orbit of a host."""

from __future__ import annotations

from ..hosts.host_orbit import host_flow, no_impacts
from ..numerics.compiling import jit
from ..orbit.variations import place_state
from ..scene.codes import EXPONENTS, OK
from .verdict import evidence_in, judge


@jit(entry=True)
def judge_host(body, walls, contacts, ends, record, first, stages, evidence):
    """Judge an orbit that `run_host` has run, and return a status.

    ends (2, size of a state): y at the beginning, which becomes a whole state, and the last state;
    record (periods, 2 size): the sections after `first` periods; stages: as of `judge`. evidence: a
    row of the columns KIND to POINT, for states of 2 size numbers, then impacts by wall.
    """
    flow, status = host_flow(body, walls, contacts, no_impacts(walls), 1)
    if status != OK:
        return status
    place_state(flow, ends[0].copy(), ends[0])
    N = flow.space.size
    parts = evidence_in(evidence, N, EXPONENTS + N * (N + 2), walls.number)
    return judge(flow, ends, record, first, stages, parts)
