"""What several test files need: reference states, systems from plain numbers, single orbits."""

import json
from dataclasses import astuple, dataclass
from functools import cache
from pathlib import Path

import numpy as np

import nlds_vines as nv
from nlds_vines.engine.batch import parts_of
from nlds_vines.engine.simulation import simulate
from nlds_vines.kernels.cells.cells import run_cell
from nlds_vines.kernels.events.contact import Steps, contact
from nlds_vines.kernels.impact.arc import make_arc
from nlds_vines.kernels.impact.impact import short_impact
from nlds_vines.kernels.laws.hertz import hertz_wall_at
from nlds_vines.kernels.motion.flight import (
    COEF,
    PERIOD,
    TAYLOR,
    TERMS,
    Grid,
    cells_of,
    expand,
    grid_from,
    rate_of,
)
from nlds_vines.kernels.orbit import variations
from nlds_vines.kernels.orbit.orbit import STATE_SIZE
from nlds_vines.kernels.scene.codes import OK, RELEASED
from nlds_vines.kernels.scene.law import SCRATCH as STEP_SCRATCH
from nlds_vines.kernels.scene.scene import (
    CellBuffers,
    Parts,
    Side,
    Span,
    Watch,
    damper_in,
    structure_under,
)
from nlds_vines.kernels.watch.observe import IMPACT_COLUMNS, Impacts
from nlds_vines.model.catalog import load_system
from nlds_vines.model.presets import CELL
from nlds_vines.model.scenes import SCENES
from nlds_vines.model.system import System

REPO = Path(__file__).resolve().parents[1]
BOTH = ("section", "impacts")  # what the tests record unless they need more: one compilation
FULL = (*BOTH, "energy", "clearance")


@dataclass(frozen=True)
class Reference:
    """A reference orbit from rest: row n - 1 belongs to t = nT."""

    parameters: dict
    states: np.ndarray
    impacts: np.ndarray
    growth: np.ndarray  # of an error in the start state; 1 where it is not known or less

    @property
    def numbers(self):
        return {name: value for name, value in self.parameters.items() if name != "kind"}


@cache
def references():
    """Return the frozen states of `data/reference/states.json` by name."""
    cases = json.loads((REPO / "data" / "reference" / "states.json").read_text())["cases"]
    orbits = {}
    for name, case in cases.items():
        rows = [case["states"][str(n)] for n in range(1, len(case["states"]) + 1)]
        orbits[name] = Reference(
            parameters=case["parameters"],
            states=np.array([[float(text) for text in row["y"]] for row in rows]),
            impacts=np.array([row["impacts"] for row in rows]),
            growth=np.array([max(1.0, row.get("growth") or 1.0) for row in rows]),
        )
    return orbits


def system_of(kind, numbers):
    """Return the system of a kind, with those of the numbers that it has; K as given."""
    scene = SCENES[kind]
    names = (*scene.parameter_names, *(("K",) if scene.walls else ()))
    return System(kind, {name: numbers[name] for name in names})


def follow_ssul(numbers, start, periods, **options):
    return simulate(system_of("ssul", numbers), periods, start=start, record=BOTH, **options)


def kernel_cell(**numbers):
    """Return the kernels' record of some parameters; what is not given is 0."""
    cell = np.zeros(1, CELL)
    for name in set(CELL.names) & numbers.keys():
        cell[name] = numbers[name]
    return cell.view(np.recarray)[0]


UNDER_FORCE = Parts(*[None] * len(Parts._fields))


def contact_parts(**numbers):
    """Return (structure, damper, near wall) as kernels see them, for a contact on its own."""
    cell = kernel_cell(**numbers)
    damper = damper_in(cell)
    return structure_under(UNDER_FORCE, cell), damper, hertz_wall_at(cell.near, damper.inv_mu, cell)


NOTHING = Watch(None, None, None, None, None, None)
EVEN = Steps(28.0, np.inf)


def side_of(parts, arc=None, steps=EVEN, rate=None, **others):
    """Return the `Side` of a wall with its bodies, on its own (see `contact_parts`)."""
    ps, damper, wall = parts
    rate = rate_of(ps, damper) if rate is None else rate
    side = Side(None, ps, damper, wall, 1.0, arc, None, steps, rate, np.zeros(STEP_SCRATCH))
    return side._replace(**others)


def follow_contact(side, wave, start, stop=1.0e3):
    """Return what `contact` does from (q, s, x1, v1) on, up to a time; the depth is noted, too."""
    noted = Impacts(np.zeros((1, IMPACT_COLUMNS)), np.zeros(1, np.int64))
    return contact(side, NOTHING._replace(impacts=noted), wave, start, stop)


@dataclass(frozen=True)
class Impact:
    """One contact from touch to release, and the state at its end."""

    speed: float  # of release [m/s]
    x1: float
    v1: float
    duration: float  # [s]
    depth: float  # [m]

    def difference(self, other):
        """Return the largest difference, relative to the scales of the impact."""
        reach = max(abs(other.x1), other.depth)
        scales = other.speed, reach, other.speed, other.duration, other.depth
        pairs = zip(astuple(self), astuple(other), scales, strict=True)
        return max(abs(a - b) / scale for a, b, scale in pairs)


@dataclass(frozen=True)
class Approach:
    """A touch about to happen: approach speed, the structure's state, phase of the forcing."""

    speed: float
    x1: float
    v1: float
    phase: float

    @property
    def wave(self):
        return float(np.cos(self.phase)), float(np.sin(self.phase))

    @property
    def touch(self):
        return 0.0, self.speed, self.x1, self.v1  # q, s, x1, v1

    def step(self, parts, steps, rk4=None):
        """Follow the contact by Taylor steps of order 14, or four if `rk4`."""
        side = side_of(parts, steps=Steps(float(steps), np.inf), rate=1.0, rk4=rk4)
        event, _, s, x1, v1, took, depth = follow_contact(side, self.wave, self.touch)
        assert event == RELEASED
        return Impact(-s, x1, v1, took, depth)

    def solve(self, parts, nodes):
        side = side_of(parts, make_arc(nodes=nodes), rate=1.0)
        solved, s, x1, v1, took, depth = short_impact(side, True, self.wave, self.touch)
        assert solved
        return Impact(-s, x1, v1, took, depth)


def flight_parts(**numbers):
    """Return (structure, damper, grid of a period) as kernels see them, for a flight on its own."""
    cell = kernel_cell(**numbers)
    ps, damper = structure_under(UNDER_FORCE, cell), damper_in(cell)
    return ps, damper, grid_from(ps, damper, cells_of(ps, damper), PERIOD)


def expanded(ps, damper, grid, y, phase):
    """Return the terms of (x1, v1, r, s) by the place in a cell, a row each."""
    out = np.zeros(TERMS)
    expand(ps, damper, grid.h, np.array([*y, np.cos(phase), np.sin(phase)]), out, 0)
    return out.reshape(-1, 4).T


def grid_with(p, h=0.1):
    """Return a grid whose expanded cell of h seconds holds the polynomial p(x) as r."""
    table, speeds = np.zeros(TAYLOR), p.deriv().coef / h
    table[COEF + 2 : COEF + 2 + 4 * len(p.coef) : 4] = p.coef
    table[COEF + 3 : COEF + 3 + 4 * len(speeds) : 4] = speeds
    return Grid(8, h, 0.125, 1.0, 1.0, 1.0, table, None)


def run_cell_rows(cell, start, periods, method="exact", settings=None):
    """Follow a damper between two walls from (x1, v1, r, s); return section and impact rows."""
    state = np.zeros(STATE_SIZE)
    state[:4] = start
    section = np.empty((periods, 4))
    impacts = Impacts(np.empty((4000, IMPACT_COLUMNS)), np.zeros(1, np.int64))
    code = run_cell(
        parts_of(method, SCENES["ssbl"], settings), cell, state, Span(0, periods, 1),
        CellBuffers(section=section, impacts=impacts),
    )  # fmt: skip
    assert code == OK
    return section, impacts.data[: impacts.filled[0]]


def follow_ssbl(numbers, periods, method="exact", settings=None):
    """Follow an SSbl damper from rest, whether or not the package has a scene of that name."""
    cell = kernel_cell(**numbers, near=numbers["D"], far=numbers["C"], rest=numbers["D"])
    return run_cell_rows(cell, np.zeros(4), periods, method, settings)


def period_map(flow, y, periods=1):
    """Return the state some periods after y (4,), and its derivative (4, 4)."""
    state, tangent = variations.new_state(), np.zeros(16)
    variations.place_state(flow, np.asarray(y, float), state)
    variations.set_identity(tangent)
    section = variations.no_section(flow.space)
    for _ in range(periods):
        assert variations.advance_flow(flow, section, 1, tangent, state) == OK
    return state[:4].copy(), tangent.reshape(4, 4).T.copy()


def differences(flow, y, changes, periods=1):
    """Return the change of the state some periods later by each change of y, centrally."""
    pairs = ([period_map(flow, y + sign * e, periods)[0] for sign in (1, -1)] for e in changes)
    return np.array([(ahead - behind) / 2 for ahead, behind in pairs]).T


def kernel_state(system, state):
    """Return (x1, v1, r, s), as kernels have it, of a state (x1, v1, x2, v2)."""
    x1, v1, x2, v2 = state
    return np.array([x1, v1, x1 - x2 + system.rest, v1 - v2])


def linear_flow(p):
    """Return the matrix of (x1, v1, x2 - rest, v2, cos, sin)' without contact."""
    m1, m2, k2, c2 = p["m1"], p["m2"], p["k2"], p["c2"]
    flow = np.zeros((6, 6))
    flow[0, 1] = flow[2, 3] = 1
    flow[1, :5] = -(p["k1"] + k2) / m1, -(p["c1"] + c2) / m1, k2 / m1, c2 / m1, p["P"] / m1
    flow[3, :4] = k2 / m2, c2 / m2, -k2 / m2, -c2 / m2
    flow[4, 5], flow[5, 4] = -p["omega"], p["omega"]
    return flow


def amplitudes(p):
    """Return the complex amplitudes of x1 and x2 - rest, of x = Re(X e^(i omega t))."""
    w = p["omega"]
    impedance = np.array([[p["k1"] - p["m1"] * w**2 + 1j * w * p["c1"]]])
    if "m2" in p:
        joint = p["k2"] + 1j * w * p["c2"]
        impedance = np.diag([impedance[0, 0], -p["m2"] * w**2])
        impedance = impedance + joint * np.array([[1, -1], [-1, 1]])
    force = np.zeros(len(impedance))
    force[0] = p["P"]
    return np.linalg.solve(impedance, force)


def steady_state(p, rest=0.0):
    """Return (x1, v1, x2, v2) at phase zero, the first two without a damper."""
    state = np.array([x for X in amplitudes(p) for x in (X.real, (1j * p["omega"] * X).real)])
    if len(state) == 4:
        state[2] += rest
    return state


def shortening(p):
    """Return the amplitude of r = x1 - x2 + rest of the impact-free response."""
    X = amplitudes(p)
    return abs(X[0] - X[1])


def bits():
    """Return short runs of both methods: what must not depend on compilation, to the last bit.

    The SSul runs hold short impacts, stepped ones and a section inside a contact.
    """
    digests = {}
    for method, options in (("exact", {}), ("rk4", {"method": "rk4", "period_steps": 64.0})):
        runs = {
            "ssul": simulate(load_system("ssul-set6"), 5, record=BOTH, **options),
            "seen": simulate(load_system("ssul-set6", omega=7.45), 3, record=FULL, **options),
            "tmd": simulate(load_system("tmd"), 5, record=("section", "energy"), **options),
        }
        for name, orbit in runs.items():
            digests[f"{method} {name} section"] = orbit.section
            scalars = orbit.E1max, orbit.E2max, orbit.clearance
            digests[f"{method} {name} scalars"] = np.array(scalars, dtype=float)
            if orbit.impacts is not None:
                columns = [orbit.impacts[c] for c in orbit.impacts.dtype.names[1:]]
                digests[f"{method} {name} impacts"] = np.array(columns)
    return digests


def fitted_order(errors, resolutions):
    """Return the order p of errors ~ resolution^-p, by least squares."""
    return -float(np.polyfit(np.log(resolutions), np.log(errors), 1)[0])


def counts_by_period(touches, omega, periods):
    """Return how many touches lie before t = T, 2T, ..."""
    ends = 2 * np.pi / omega * np.arange(1, periods + 1)
    return np.searchsorted(np.sort(touches), ends)


def as_host(system):
    """Return a system of one damper as a host of one degree of freedom, and its rest offset."""
    m1, k1, c1 = system.structure
    host = nv.Host([[m1]], [[k1]], [[c1]], dofs=["x"])
    scene, p = system.scene, system.parameters
    gaps = {"near": scene.gap_near, "far": scene.gap_far}
    walls = [
        nv.Wall(gaps[wall](p), side, system.law, **system.contact(wall))
        for wall, side in (("near", "+"), ("far", "-"))
        if wall in scene.walls
    ]
    if scene.damper:
        damper = nv.Damper("u", "x", m=p["m2"], k=p["k2"], c=p["c2"], walls=walls)
    else:
        damper = nv.Damper("u", ("x", "ground"), walls=walls)
    force = {"x": system.force}
    return nv.System.from_host(host, [damper], force=force, omega=p["omega"])
