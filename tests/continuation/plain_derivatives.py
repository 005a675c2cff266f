"""Derivatives of the section map by parameters, beside differences of the map.

Parameters of systems that together have every law, walls on both sides, walls that limit the
structure itself, a constant load and a damper that sticks.
"""

import numpy as np
import pytest

from nlds_vines import System, load_system, simulate
from nlds_vines.engine.section_map import SectionMap
from nlds_vines.engine.solver_settings import Settings
from nlds_vines.engine.starts import user_states

SET_6 = load_system("ssul-set6")
TWO_STOPS = {"m": 1.0, "k": 1.0, "c": 0.2, "C": 1.0, "C_2": 0.9, "omega": 0.5, "P": 1.5}
TWO_LAWS = {"kc": 20.0, "cc": 1.0, "e_2": 0.7}
BALL = {"m": 1.0, "g": 9.81, "Y": 0.01, "omega": 40.0, "e": 0.5}
SYSTEMS = {
    "hertz": SET_6,
    "power": SET_6.with_(law="power", K=1e5, exponent=1.2, hunt_crossley=0.2),
    "restitution": SET_6.with_(law="restitution", e=0.7),
    "kelvin-voigt": SET_6.with_(law="kelvin-voigt", kc=2e4, cc=30.0),
    "two laws": System("oscillator-2", TWO_STOPS | TWO_LAWS, law="linear", law_2="restitution"),
    "sticking": System("ball", BALL, law="restitution"),
    "moving ground": SET_6.with_(base_acceleration=0.8),
    "stuck on moving ground": SET_6.with_(
        base_displacement=0.02, law="restitution", e=0.0, C=-0.02
    ),
}
STEPPED = ("m2", "C", "omega", "K", "exponent", "hunt_crossley")
"""Of "power": one of a body, a place and the drive, and the law's; others vary the same steps."""
ON_GROUND = ("m1", "m2", "omega", "base_acceleration", "base_displacement")
"""On moving ground: what changes the force on either body, and how they move as one mass."""
FEW = {"power": STEPPED, "moving ground": ON_GROUND, "stuck on moving ground": ON_GROUND}
PAIRS = [
    (name, parameter)
    for name, system in SYSTEMS.items()
    for parameter in system.parameters
    if parameter in FEW.get(name, system.parameters)
]


def image(system, y, periods=1, tolerance=1e-13):
    """Return the image of a state of the kernels by `simulate`, which carries no variations."""
    state = np.zeros(4)
    state[: len(y)] = y
    start = user_states(system.cells(), state, system.scene)
    options = {"record": ["section"], "tolerance": tolerance, "quiet": True}
    end = simulate(system, periods, start=start, **options).state
    if len(y) == 4:
        end = np.array([end[0], end[1], end[0] - end[2] + system.rest, end[1] - end[3]])
    return end


@pytest.fixture(scope="module")
def starts():
    """Return a state of each system, after some periods from rest."""
    begun = {name: np.zeros(len(system.scene.components)) for name, system in SYSTEMS.items()}
    begun["sticking"][:] = 0.01, 0.1
    begun["stuck on moving ground"][2] = -0.03  # in front of the wall
    return {name: image(SYSTEMS[name], y, 12, 1e-12) for name, y in begun.items()}


def of_differences(system, parameter, y):
    """Return the derivative of the image of `y` by a parameter, of differences.

    Each step is half of the one before, and each row of Ridders' table has two orders more; of all
    that number is taken which differs least from its neighbors in the table.
    """
    value = system.parameters[parameter]
    table, least = [], (np.inf, np.nan)
    for step in (abs(value) or 1e-2) * np.array([5e-4, 2.5e-4, 1.25e-4]):
        sides = [image(system.with_(**{parameter: value + one}), y) for one in (step, -step)]
        row = [(sides[0] - sides[1]) / (2.0 * step)]
        for k, before in enumerate(table[-1] if table else ()):
            row.append(row[k] + (row[k] - before) / (4.0 ** (k + 1) - 1.0))
            error = max(np.abs(row[k + 1] - row[k]).max(), np.abs(row[k + 1] - before).max())
            least = min(least, (error, row[k + 1]), key=lambda pair: pair[0])
        table.append(row)
    return least[-1]


@pytest.mark.parametrize(("name", "parameter"), PAIRS)
def test_the_derivative_by_each_parameter_is_that_of_differences(starts, name, parameter):
    system, value = SYSTEMS[name], SYSTEMS[name].parameters[parameter]
    section_map = SectionMap(system, (parameter,), Settings(1e-13))
    place, unit = np.append(starts[name], value), abs(value) or 1e-2
    cycle = section_map.at(place, 1)
    assert sum(cycle.counts) >= 1
    expected = of_differences(system, parameter, starts[name])
    off = np.abs(cycle.slopes[0] - expected).max()
    round_off = 1e-11 * np.abs(cycle.points[0, : section_map.size]).max() / unit
    assert off <= 1e-8 * np.abs(expected).max() + round_off


def test_two_parameters_have_the_derivatives_of_each(starts):
    for names in (("omega", "P"), ("C", "K"), ("m2", "V")):
        system = SET_6.with_(K=SET_6.K)
        values = [system.parameters[name] for name in names]
        place = np.concatenate([starts["hertz"], values])
        both = SectionMap(system, names, Settings(1e-12)).at(place, 1)
        for i, name in enumerate(names):
            alone = SectionMap(system, (name,), Settings(1e-12))
            one = alone.at(np.append(starts["hertz"], values[i]), 1)
            size = np.abs(one.slopes[0]).max()
            assert np.allclose(both.slopes[i], one.slopes[0], rtol=0, atol=1e-10 * size)


def test_a_wall_that_pushes_at_the_section(starts):
    """Where the section cuts an impact in two, both parts are driven."""
    section_map = SectionMap(SET_6, ("omega",), Settings(1e-13))
    orbit, omega = starts["hertz"], SET_6.parameters["omega"]
    place = np.append(orbit, omega)
    place[2:4] = SET_6.parameters["C"] + 1e-5, 0.2  # inside a contact
    expected = of_differences(SET_6, "omega", place[:4])
    off = np.abs(section_map.at(place, 1).slopes[0] - expected).max()
    assert off <= 1e-8 * np.abs(expected).max()
    back = place.copy()
    back[3] = 0.0
    cycle = section_map.at(back, 2)
    assert np.isfinite(cycle.slopes).all()
