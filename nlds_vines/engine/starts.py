"""The start states of a scan: policies, states of the request, random states."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from nlds_vines.errors import RequestError, number, shown
from nlds_vines.model.axis import real_array
from nlds_vines.model.parameters import INITIAL, PHASE
from nlds_vines.model.scenes import Scene, Values
from nlds_vines.model.setting import Checked, OneOf, Whole, check_settings, setting

POLICIES = ("rest", "up", "down", "both", "random")  # and `STATE`

STATE = "state"  # the policy of orbits that start in a state of the request

# the policies whose starts may have initial conditions of their own, and another phase than 0
AT_ANY_PHASE = ("rest", STATE)

# the sweeps of a policy along the last axis, in the order of the starts
SWEEPS: Mapping[str, tuple[str, ...]] = {"up": ("up",), "down": ("down",), "both": ("up", "down")}

# largest displacements in a random start, in static deflections P / k1: of the structure, and of
# the damper against it
STRUCTURE_SPREAD, DAMPER_SPREAD = 5.0, 15.0
# depth inside a wall up to which a start counts as on it, relative to displacements: r is a
# difference of x1 and x2, whose round-off may exceed that of a small gap
ROUND_OFF = 1e-12
LEAST_AMPLITUDE = 1e-6  # relative to the unit of length; below it, amplitudes are not resolved
FALLBACK_LENGTH = 0.01  # unit of length [m] if no parameter of the system gives one


@dataclass(frozen=True)
class Start:
    """The start states of the orbits of every cell, validated.

    Orbits of `up` and `down` start on the attractor of the neighboring cell along the last axis, so
    that `both` shows hysteresis; those of `random` in the same states in every cell.  The periods
    of an orbit count from the first section, at phase 0.
    """

    policy: str = setting(
        "rest", OneOf((*POLICIES, STATE)), "start",
        "where the orbits begin: [`rest`, `up`, `down`, `both`, `random`]"
        "(scans.md#where-orbits-begin)",
        replaces=("count", "seed", "state", "phase"),
    )  # fmt: skip
    count: int = setting(1, Whole(1, 10**6), "start", "for `random` only: how many starts")
    seed: int = setting(0, Whole(0, 2**63 - 1), "start", "for `random` only: what draws them")
    state: tuple[float, ...] = setting(
        (), Checked(lambda value: _numbers(value)), "start",
        "where all orbits begin: x1, v1, x2, v2 at t = 0 [m, m/s]; the policy is then `state`",
        replaces=("policy", "count", "seed"),
    )  # fmt: skip
    phase: float = setting(
        0.0, Checked(lambda value: _phase(value)), "start",
        "for `rest` and a state: the [phase](transients.md#basins-of-attraction) of the force at "
        "the start [rad], 0 to 2 pi",
    )  # fmt: skip

    def __post_init__(self) -> None:
        check_settings(self)
        if bool(self.state) != (self.policy == STATE):
            raise RequestError(
                f"policy {self.policy!r} with state = {shown(list(self.state))}: a state belongs "
                f"to policy {STATE!r}, which needs one"
            )
        if self.phase and self.policy not in AT_ANY_PHASE:
            raise RequestError(
                f"phase = {self.phase!r} with policy {self.policy!r}: orbits that begin at another "
                f"phase than 0 have policy {' or '.join(map(repr, AT_ANY_PHASE))}"
            )
        if self.policy != "random" and (self.count, self.seed) != (1, 0):
            raise RequestError(
                f"count and seed belong to policy 'random', not to policy {self.policy!r}"
            )

    @property
    def sweeps(self) -> tuple[str, ...]:
        """The sweeps along the last axis; none if every cell has starts of its own."""
        return SWEEPS.get(self.policy, ())

    @property
    def orbits(self) -> int:
        return len(self.sweeps) or self.count

    @property
    def names(self) -> tuple[str, ...]:
        """The names of the orbits of a cell: `rest`, `up`, `down`; `random 0`, `random 1`."""
        if self.policy == "random" and self.count > 1:
            return tuple(f"random {i}" for i in range(self.count))
        return self.sweeps or (self.policy,)


def _phase(value: object) -> float:
    phase = number("phase", value)
    INITIAL[PHASE].check(np.array([phase]))
    return phase


def _numbers(state: object) -> tuple[float, ...]:
    if isinstance(state, str) or not isinstance(state, Sequence) or len(state) % 2:
        raise RequestError(f"state = {shown(state)} must be a list of 4 numbers, or of 2")
    return tuple(number("state", value) for value in state)


def checked_start(start: Any, names: Sequence[str]) -> np.ndarray:
    """Return the state of the components `names` in which an orbit starts."""
    try:
        values = real_array("start", start)
    except RequestError:
        values = np.zeros((0, 0))
    if values.shape != (len(names),):  # its text takes longer than an orbit to start
        raise RequestError(
            f"start = {shown(start)}; allowed: {len(names)} finite numbers {', '.join(names)}"
        )
    return values


def given_states(
    cells: np.ndarray, start: Start, initial: Mapping[str, np.ndarray], scene: Scene
) -> np.ndarray:
    """Return the kernels' states (n, 4) of starts that are not random: x1, v1, r, s.

    `initial` conditions by component, (n,) each [m, m/s], override the `start`.
    r = x1 - (x2 - rest), s = v1 - v2.  Kernels put a start beyond a rigid wall on the wall.
    """
    names, states = scene.components, np.zeros((len(cells), 4))
    values = dict(zip(names, start.state, strict=True)) if start.state else {}
    if not {*values, *initial}:
        return states
    columns = {name: np.broadcast_to(values.get(name, 0.0), len(cells)) for name in names}
    if scene.damper and not start.state:
        columns["x2"] = cells["rest"]
    columns |= initial
    states[:, 0], states[:, 1] = columns[names[0]], columns[names[1]]
    if scene.damper:
        states[:, 2] = columns["x1"] - (columns["x2"] - cells["rest"])
        states[:, 3] = columns["v1"] - columns["v2"]
    elif scene.grounded:
        states[:, 2:] = states[:, :2]
    return states


def starts_inside(
    system: Any, values: Values, state: Mapping[str, Any], shape: tuple[int, ...] = ()
) -> list[str]:
    """Return a line with the number of starts inside a wall and the largest depth; [] for none.

    `values` are parameters that differ from those of a system of any kind.  They and the components
    of the state are floats or arrays that broadcast to `shape`, the shape of the starts.  A missing
    component is at rest.
    """
    depth, scale = np.full(shape, -np.inf), np.zeros(())
    for stroke in system.strokes(values, state):
        scale = np.maximum(scale, stroke.terms)
        for sign, gap in stroke.walls:
            depth = np.maximum(depth, sign * stroke.r - gap)
    inside = depth > ROUND_OFF * scale
    if not inside.any():
        return []
    most = f"{1e3 * float(depth.max()):.4g} mm deep at most"
    is_rigid = all(law.instant for law in system.contact_laws)
    moved = " and put on it" if is_rigid else ""
    count = np.count_nonzero(inside)
    verb = "is" if count == 1 else "are"
    return [f"{count} of {depth.size} starts {verb} inside a wall{moved}, {most}"]


def start_states(start: Start, size: int = 4) -> np.ndarray:
    """Return uniform draws (starts, size) in [-1, 1) for `random_states`, the same for each cell.

    A larger number of starts with the same seed begins with the same draws.
    """
    generator = np.random.default_rng(start.seed)
    # the only product, by 2, is exact: the same bits on every processor
    return generator.uniform(-1.0, 1.0, size=(start.orbits, size))


def random_states(cells: np.ndarray, draws: np.ndarray, scene: Scene) -> np.ndarray:
    """Return the start states of `draws` (starts, 4) in each of the `cells` of any shape.

    Returns x1 [m], v1 [m/s], r = x1 - x2 + rest [m] and s = v1 - v2 [m/s], shape
    (cells' shape, starts, 4), all finite, from draws a, b, c, d:
    x1 = 5 l a, v1 = 5 l omega b, r = 15 l c, s = 15 l omega d with the length l = P / k1, and r
    clipped to the walls, -far <= r <= near.  If a scene has a limit, r beyond it is mirrored at it,
    as a start on the limit would often become a violation.
    """
    length = length_unit(cells)[..., np.newaxis]
    speed = length * cells["omega"][..., np.newaxis]
    a, b, c, d = np.moveaxis(draws, -1, 0)
    r = DAMPER_SPREAD * length * c
    if "near" in scene.walls:
        r = np.minimum(r, cells["near"][..., np.newaxis])
    if scene.limit is not None:
        limit = cells["limit"][..., np.newaxis]
        r = np.where(r > limit, 2 * limit - r, r)
    if "far" in scene.walls:
        r = np.maximum(r, -cells["far"][..., np.newaxis])
    x1, v1 = STRUCTURE_SPREAD * length * a, STRUCTURE_SPREAD * speed * b
    if scene.grounded:  # the walls limit x1
        for name, sign in (("near", 1.0), ("far", -1.0)):
            if name in scene.walls:
                x1 = sign * np.minimum(sign * x1, cells[name][..., np.newaxis])
    return np.stack([x1, v1, r, DAMPER_SPREAD * speed * d], axis=-1)


def user_states(cells: np.ndarray, states: np.ndarray, scene: Scene) -> np.ndarray:
    """Return states of the kernels (..., 4) in the user's coordinates (..., components)."""
    if not scene.damper:
        return states[..., :2].copy()
    x1, v1, r, s = np.moveaxis(states, -1, 0)
    return np.stack([x1, v1, x1 - r + cells["rest"], v1 - s], axis=-1)


def put_on_walls(cells: np.ndarray, states: np.ndarray, scene: Scene) -> np.ndarray:
    """Return states of the kernels (n, 4), with those beyond a rigid wall put on it."""
    result = states.copy()
    limited = [0, 2] if scene.grounded else [2]  # x1, or r
    for name, sign in (("near", 1.0), ("far", -1.0)):
        if name in scene.walls and scene.law_at(name).instant:
            place = sign * cells[name][:, np.newaxis]
            nearest = np.minimum if sign > 0 else np.maximum
            result[:, limited] = nearest(result[:, limited], place)
    return result


def length_unit(cells: np.ndarray) -> np.ndarray:
    """Return the unit of length [m] of random starts, positive and finite in every cell.

    It is the static deflection |P| / k1; if that is 0 or infinite, the largest of
    |P| / (m1 omega^2) and the distances of the walls; if these are 0 too, `FALLBACK_LENGTH`.
    """

    def is_length(values: np.ndarray) -> np.ndarray:
        return (values >= 1e-15) & (values <= 1e6)

    with np.errstate(all="ignore"):
        force = np.abs(cells["P"])
        static = force / cells["k1"]
        inertial = force / (cells["m1"] * cells["omega"] * cells["omega"])
    walls = np.maximum(np.abs(cells["near"]), np.abs(cells["far"]))
    other = np.maximum(np.where(is_length(inertial), inertial, 0.0), walls)
    return np.select([is_length(static), is_length(other)], [static, other], FALLBACK_LENGTH)
