"""`simulate`: settings and starts of all kinds, impacts row by row, refusals, tables."""

import os
import threading

import numpy as np
import pytest
from commands import printed
from scipy.optimize import brentq
from support import BOTH, FULL, REPO, bits, counts_by_period, follow_ssul, references, system_of
from twin import follow, model_of

import nlds_vines as nv
from nlds_vines.bifurcation.request import load_scan
from nlds_vines.engine import solver_settings as solver
from nlds_vines.engine.batch import start_state
from nlds_vines.engine.kind_engine import SHORT
from nlds_vines.engine.one_orbit import IntegrationError, Orbit
from nlds_vines.engine.simulation import simulate
from nlds_vines.engine.solver_settings import Settings, checked_tolerance, chosen_settings
from nlds_vines.engine.starts import given_states, starts_inside
from nlds_vines.model.catalog import catalog, load_system

SET6 = references()["ssul-set6"].numbers
ROUND = {**SET6, "V": 0.125, "C": 0.0625}  # so that a start can lie on the wall to the last bit
RK4 = pytest.param({"method": "rk4", "period_steps": 4096.0}, id="rk4", marks=pytest.mark.kernels)
both_methods = pytest.mark.parametrize("options", [pytest.param({}, id="exact"), RK4])
exact_plain = pytest.mark.parametrize(
    "options", [pytest.param({}, id="exact", marks=pytest.mark.plain), RK4]
)
"""For scenes that no other test follows so: by fixed steps it is faster to compile, by exact flight
it is not."""


def assert_as_twin(numbers, start, periods, options, bound=1e-8):
    """Compare sections and impacts with the twin's; return the orbit."""
    orbit = follow_ssul(numbers, start, periods, **options)
    course = follow(model_of(numbers), start, periods)
    np.testing.assert_allclose(orbit.section, course.section, rtol=0, atol=bound)
    np.testing.assert_array_equal(orbit.state, orbit.section[-1])
    impacts, rows = orbit.impacts, course.touches
    assert len(impacts) == len(rows)
    assert set(impacts["wall"]) <= {"obstacle"}
    over = ~np.isnan(impacts["release"])  # the deepest point of the others is still to come
    for column, name in enumerate(("touch", "release", "speed", "depth"), start=1):
        which = over if name == "depth" else slice(None)
        np.testing.assert_allclose(impacts[name][which], rows[which, column], rtol=0, atol=bound)
    force = numbers["K"] * impacts["depth"] ** 1.5
    np.testing.assert_allclose(impacts["force"], force, rtol=1e-12)
    return orbit


def shortened(numbers, r, v1=0.0, s=0.0):
    """Return the start with x1 = 0 and the spring shortened by r at the rate s."""
    return np.array([0.0, v1, numbers["V"] + numbers["C"] - r, v1 - s])


@both_methods
@pytest.mark.parametrize("K", [1e3, 1e5, 1.6e11])
def test_impacts_as_the_twin_sees_them(K, options):
    numbers = {**SET6, "K": K}
    orbit = assert_as_twin(numbers, shortened(numbers, 0.0), 8, options, bound=1e-7)
    assert len(orbit.impacts) >= 5
    complete = orbit.impacts[~np.isnan(orbit.impacts["release"])]
    lasting = (complete["release"] - complete["touch"]).max() * SET6["omega"] / (2 * np.pi)
    assert lasting > 0.3 if K == 1e3 else lasting < 0.2


@both_methods
def test_a_contact_that_a_section_or_the_end_cuts_goes_on_as_if_it_were_not(options):
    """At 4T of the reference orbit a contact is under way."""
    orbit = follow_ssul(SET6, None, 4, **options)
    x1, _, x2, _ = orbit.section[-1]
    assert SET6["V"] - (x2 - x1) > 1e-4
    assert np.isnan(orbit.impacts["release"][-1])
    assert not np.isnan(orbit.impacts["release"][:-1]).any()
    expected = references()["ssul-set6"].states[3]
    np.testing.assert_allclose(orbit.section[-1], expected, rtol=0, atol=1e-8)
    # impacts and sections go on as if the section had not cut the contact in two
    orbit = assert_as_twin(SET6, shortened(SET6, 0.0), 8, options, bound=1e-7)
    ends = 2 * np.pi / SET6["omega"] * np.arange(1, 9)
    touch, release = orbit.impacts["touch"], orbit.impacts["release"]
    inside = [end for end in ends if np.any((touch < end) & (end < release))]
    assert len(inside) >= 2  # at 4T and 5T


def test_impact_times_count_from_the_start_of_the_transient():
    whole = follow_ssul(SET6, None, 12)
    late = follow_ssul(SET6, None, 6, transient=6)
    np.testing.assert_array_equal(late.section, whole.section[6:])
    np.testing.assert_array_equal(late.impacts, whole.impacts[-len(late.impacts) :])
    counts = counts_by_period(whole.impacts["touch"], SET6["omega"], 12)
    assert len(late.impacts) == counts[11] - counts[5]


SOFT, CLOSE = {**SET6, "K": 1e6}, {**SET6, "C": 0.0}
BEGUN = {  # parameters, how far within the wall and how fast: the earliest touch, and its speed
    "inside, moving away": (SOFT, 0.01, -0.5, 0.05, None),  # the contact under way is no impact
    "inside, at rest": (SOFT, 0.01, 0.0, 0.05, None),
    "inside, moving in": (SOFT, 0.01, 0.5, 0.05, None),
    "on it, moving in": (ROUND, 0.0, 1.0, 0.0, 1.0),
    "on it, moving away": (ROUND, 0.0, -1.0, 0.1, None),
    "on it, pressed in": (CLOSE, 0.0, 0.0, 0.0, 0.0),  # without a clearance, from the first instant
    "on a soft one, pressed in": ({**CLOSE, "K": 1e3}, 0.0, 0.0, 0.0, 0.0),
}


@both_methods
@pytest.mark.parametrize("begun", BEGUN)
def test_start_at_a_wall(begun, options):
    numbers, depth, s, earliest, speed = BEGUN[begun]
    start = shortened(numbers, numbers["C"] + depth, s=s)
    first = assert_as_twin(numbers, start, 4, options, bound=1e-7).impacts[0]
    if speed is None:
        assert first["touch"] > earliest
    else:
        assert abs(first["touch"]) <= 1e-15
        assert first["speed"] == pytest.approx(speed, abs=1e-12 * (speed == 0.0))


def pressed(numbers):
    """Return the state at rest of a preloaded damper: k2 (C + z) + K z^(3/2) = 0."""
    k2, C, K = (numbers[name] for name in ("k2", "C", "K"))
    z = brentq(lambda z: k2 * (C + z) + K * z**1.5, 0.0, -C, xtol=1e-18)
    return shortened(numbers, numbers["C"] + z)


PRELOADED = {**SET6, "C": -0.005}


@both_methods
def test_a_preloaded_damper_rests_on_the_obstacle_stays_at_rest_or_lifts_off(options):
    # shaken too gently to lift off: one contact of four periods, no impact
    numbers = {**PRELOADED, "P": 2.0}
    orbit = assert_as_twin(numbers, pressed(numbers), 4, options, bound=1e-12)
    assert len(orbit.impacts) == 0
    u = orbit.section[:, 2] - orbit.section[:, 0]
    assert (u < numbers["V"]).all()
    # at rest it stays at rest
    numbers = {**PRELOADED, "P": 0.0, "c1": 0.0, "c2": 0.0}
    start = pressed(numbers)
    orbit = follow_ssul(numbers, start, 20, **options)
    np.testing.assert_allclose(orbit.section, np.tile(start, (20, 1)), rtol=0, atol=1e-14)
    # or it lifts off
    numbers = {**PRELOADED, "P": 100.0}
    orbit = assert_as_twin(numbers, pressed(numbers), 3, options, bound=1e-5)
    assert len(orbit.impacts) > 3
    # nothing moves on the wall
    numbers = {**ROUND, "C": 0.0, "P": 0.0}
    orbit = follow_ssul(numbers, None, 3, **options)
    np.testing.assert_array_equal(orbit.section, [[0.0, 0.0, 0.125, 0.0]] * 3)
    assert len(orbit.impacts) == 0


@both_methods
@pytest.mark.parametrize(
    ("changes", "status"),
    [
        ({"c2": 1e12}, "too_stiff"),
        ({"omega": 1e-6}, "too_stiff"),
        ({"P": 1e200}, "diverged|step_b"),
    ],
)
def test_absurd_parameters_end_in_a_status(changes, status, options):
    with pytest.raises(IntegrationError, match=status):
        follow_ssul({**SET6, **changes}, None, 3, **options)


@pytest.mark.kernels
def test_fixed_steps_beyond_their_stability_are_refused():
    """512 steps of a period are too few for this dashpot: plausible numbers would be invented."""
    numbers = {**SET6, "c2": 1e5}
    with pytest.raises(IntegrationError, match="too_stiff"):
        follow_ssul(numbers, None, 3, method="rk4", period_steps=512.0)
    assert len(follow_ssul(numbers, None, 3).impacts) == 0


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"periods": -1}, "periods"),
        ({"periods": 2.5}, "periods"),
        ({"transient": -1}, "transient"),
        ({"method": "euler"}, "method"),
        ({"record": ("section", "sections")}, "record"),
        ({"record": ("regime",)}, "record"),
        ({"start": (0.0, 0.0)}, "start"),
        ({"start": (0.0, 0.0, np.nan, 0.0)}, "start"),
        ({"start": (0.0, 0.0, np.inf, 0.0)}, "start"),
        ({"contact_steps": 1e7}, "contact_steps"),
        ({"method": "rk4", "period_steps": 3}, "period_steps = 3; allowed: 4 to 1e6"),
        ({"system": "tmd", "record": ("impacts",)}, "no wall"),
        ({"system": "tmd", "record": ("clearance",)}, "no wall"),
        ({"law": "restitution", "e": 0.5, "start": (0, 0, 0.05, 0)}, "0.05 m inside the obstacle"),
        (  # each wall is judged by its own law
            {"system": "ssbl", "law_2": "restitution", "e_2": 0.7, "start": (0.0, 0.0, -0.1, 0.0)},
            "0.1 m inside the structure, which is rigid",
        ),
        ({"omga": 7.4}, "unknown parameter 'omga'; did you mean 'omega'"),
    ],
)
def test_wrong_arguments_and_what_a_scene_does_not_have_or_allow(options, words, error_of):
    assert words in error_of(simulate, **{"system": "ssul-set6", "periods": 3, **options})


@pytest.mark.kernels
def test_what_was_not_asked_for_is_none_and_of_no_periods_there_are_no_rows():
    orbit = simulate(load_system("ssul-set6"), 3, record=BOTH)
    assert orbit.E1max is None
    assert orbit.clearance is None
    assert simulate(load_system("none"), 3, record=("section", "energy")).E2max is None
    orbit = simulate(system_of("ssul", SET6), 0, record=FULL)
    assert orbit.section.shape == (0, 4)
    assert len(orbit.impacts) == 0
    assert orbit.clearance == np.inf
    assert (orbit.E1max, orbit.E2max) == (0.0, 0.0)


@pytest.mark.kernels
def test_without_the_compiler_every_bit_is_the_same(tmp_path):
    path = tmp_path / "bits.npz"
    code = f"import numpy, support; numpy.savez({str(path)!r}, **support.bits())"
    paths = os.pathsep.join([str(REPO), str(REPO / "tests")])
    printed("-c", code, PYTHONPATH=paths, NUMBA_DISABLE_JIT="1")
    plain, compiled = dict(np.load(path)), bits()
    assert plain.keys() == compiled.keys()
    for name, values in compiled.items():
        assert values.tobytes() == plain[name].tobytes(), name


SSBL = {**catalog()["ssbl"].parameters, "K": SET6["K"]}
DRAGGED = {**SSBL, "C": 0.2, "omega": 6.05}


def of_two_walls(numbers, kind="ssbl"):
    """Return the system of two walls, and the twin's course from rest."""
    watched = kind != "ssbl"
    start = (0.0, 0.0, numbers["D"], 0.0)
    return system_of(kind, numbers), follow(model_of(numbers, watched=watched), start, 4)


@pytest.mark.kernels
@exact_plain
@pytest.mark.parametrize("K", [3e8, 1e9, 1e10])
def test_depth_and_force_of_short_impacts_where_dashpots_act(K, options):
    """The depth is as good as the speed, and the force with it. Notices: nodes of the whole arc."""
    numbers = {**DRAGGED, "K": K}
    system, seen = of_two_walls(numbers)
    rows = simulate(system, 4, record=FULL, **options).impacts
    over = ~np.isnan(seen.touches[:, 2])
    assert len(rows) == len(seen.touches) >= 5
    np.testing.assert_allclose(rows["speed"], seen.touches[:, 3], rtol=3e-11)
    np.testing.assert_allclose(rows["depth"][over], seen.touches[over, 4], rtol=3e-11)
    force = K * seen.touches[over, 4] ** 1.5
    np.testing.assert_allclose(rows["force"][over], force, rtol=5e-11)


@pytest.mark.kernels
@exact_plain
@pytest.mark.parametrize(
    ("kind", "changes"),
    [
        ("ssbl", {"D": 1.0, "C": 0.2}),  # touches the far wall and misses it
        ("ssbl", {"D": 1.0, "C": 0.4}),  # misses it every time
        ("ssbl", {"D": 0.4, "C": 1.0}),  # ... or the near wall
        ("ssvi-b", {"D": 1.0, "C": 0.4}),
        ("ssvi-b", {"D": 0.06, "C": 0.4}),  # breaks the limit, which is no wall to be missed
    ],
)
def test_clearance_at_either_wall(kind, changes, options):
    """Notices: the far wall's near miss with the wrong sign, or never looked for."""
    numbers = {**SSBL, "K": 1e7, **changes}
    system, seen = of_two_walls(numbers, kind)
    orbit = simulate(system, 4, record=FULL, **options)
    real = seen.misses[seen.misses[:, 0] >= (kind != "ssbl")]
    closest = -real[:, 2].max()
    assert np.isfinite(closest)
    assert orbit.clearance == pytest.approx(closest, abs=1e-11 if not options else 1e-8)
    wall = real[real[:, 2].argmax(), 0]
    assert wall == (0 if changes["C"] == 1.0 else 1)


def test_short_orbits_run_in_the_calling_thread(monkeypatch):
    """A thread for each call costs more than a period; long orbits have one, for signals."""
    system = load_system("ssul-set6", omega=7.4)
    expected, cell = simulate(system, 3).section.tobytes(), system.cell.tobytes()

    def refuse(thread):
        raise RuntimeError("a thread")

    monkeypatch.setattr(threading.Thread, "start", refuse)
    assert simulate(system, 3).section.tobytes() == expected
    assert simulate("ssul-set6", 3, omega=7.4).section.tobytes() == expected
    assert system.cell.tobytes() == cell  # which later calls use
    with pytest.raises(RuntimeError, match="a thread"):
        simulate(system, SHORT + 1)


def made_up(name, states):
    """Return an orbit with this trajectory, 64 states a period, for a table of pandas."""
    pytest.importorskip("pandas", reason="pandas is not installed")
    system = nv.load_system(name)
    period = 2.0 * np.pi / system.parameters["omega"]
    time = np.arange(1, len(states) + 1) * period / 64
    return Orbit(system, states[-1], trajectory=np.array(states), time=time)


def test_a_trajectory_becomes_a_table(error_of):
    p = nv.load_system("ssul-set6").parameters
    states = [[0.01 * i, 0.1, 0.0, -0.2] for i in range(-64, 64)]
    frame = made_up("ssul-set6", states).to_dataframe()
    assert list(frame) == ["time", "x1", "v1", "x2", "v2", "phase", "force", "contact"]
    assert (frame[["x1", "v1", "x2", "v2"]].to_numpy() == states).all()
    assert np.allclose(frame.force, p["P"] * np.cos(p["omega"] * frame.time), atol=1e-9 * p["P"])
    assert np.allclose(frame.force, p["P"] * np.cos(frame.phase), atol=1e-9 * p["P"])
    assert (frame.phase >= 0.0).all()
    assert (frame.phase < 2.0 * np.pi).all()
    assert 0 < (frame.contact > 0.0).sum() < len(frame)
    assert set(frame.attrs["units"]) == set(frame)
    assert frame.attrs["units"]["contact"] == "N"
    # two walls have two columns
    states = [[0.05 * i, 0.0, 0.0, 0.0] for i in range(-64, 64)]
    frame = made_up("ssbl", states).to_dataframe()
    assert frame.contact_near.max() > 0.0
    assert frame.contact_far.min() < 0.0
    assert frame.contact_near.min() == frame.contact_far.max() == 0.0
    # rigid walls have none
    frame = made_up("impact-oscillator", [[0.0, 1.0], [0.1, 0.5]]).to_dataframe()
    components = nv.load_system("impact-oscillator").scene.components
    assert list(frame)[1:] == [*components, "phase", "force"]
    # without a trajectory a table is refused
    assert "no trajectory" in error_of(nv.simulate("ssul-set6", 2).to_dataframe)


def test_presets_are_numbers_by_another_name():
    assert solver.TOLERANCES == {"draft": 1e-6, "standard": 1e-9, "fine": 1e-12}
    for name, value in solver.TOLERANCES.items():
        assert checked_tolerance(name) == checked_tolerance(value) == value
    ends = solver.LEAST_TOLERANCE, solver.MOST_TOLERANCE
    assert ends == (1e-13, 1e-3)
    for value in (*ends, np.float64(1e-7), 5e-4):
        assert type(checked_tolerance(value)) is float
        assert checked_tolerance(value) == value
    usual = chosen_settings("exact", {}).tolerance
    assert usual == solver.TOLERANCE == solver.TOLERANCES["standard"]
    # contacts are granted a share of it, as several may follow each other in a period
    settings = Settings(1e-6)
    assert settings.contact_tolerance == settings.stepped_to == solver.SHARE * 1e-6
    assert Settings(1e-6, contact_steps=28.0).stepped_to == np.inf  # as an expert wants them
    assert {Settings(10.0**-k).steps for k in range(3, 14)} == {solver.LEAST_STEPS}


def test_every_method_has_its_own_settings(error_of):
    settings = {"tolerance": 1e-6, "nodes": 9, "contact_steps": 20, "period_steps": 64}
    for name in solver.FINENESS:
        method, other = ("rk4", "exact") if name == "period_steps" else ("exact", "rk4")
        assert chosen_settings(method, {name: settings[name]}) != chosen_settings(method, {})
        line = error_of(chosen_settings, other, {name: settings[name]})
        assert line.startswith(f"{name} is of method '{method}'; '{other}' has ")
        assert chosen_settings(other, {name: None}) == chosen_settings(other, {})
    assert chosen_settings("rk4", {"period_steps": 64}) == Settings.rk4(64.0)
    assert chosen_settings("rk4", {}) == Settings.rk4(solver.PERIOD_STEPS)


@pytest.mark.parametrize(
    ("below", "above", "expected"),
    [
        ({"tolerance": 1e-6}, {}, {"tolerance": 1e-6}),
        ({"tolerance": 1e-6}, {"tolerance": 1e-12}, {"tolerance": 1e-12}),
        ({"tolerance": 1e-6, "periods": 3}, {"method": "rk4"}, {"method": "rk4", "periods": 3}),
        ({"tolerance": 1e-6}, {"method": "exact"}, {"method": "exact", "tolerance": 1e-6}),
        ({"method": "rk4", "period_steps": 64}, {"method": "exact"}, {"method": "exact"}),
        ({"nodes": 8, "contact_steps": 20}, {"tolerance": 1e-6}, {"tolerance": 1e-6}),
        ({"nodes": 8}, {"contact_steps": 20}, {"nodes": 8, "contact_steps": 20}),
        ({"nodes": 8}, {"transient": 5}, {"nodes": 8, "transient": 5}),
    ],
)
def test_what_is_asked_last_counts(below, above, expected):
    one = {"system": "tmd", "vary": {"omega": {"values": [6.0]}}}
    scan = load_scan(one | {"sampling": below}, {"sampling": above})
    other = load_scan(one | {"sampling": expected})
    assert scan.document()["sampling"] == other.document()["sampling"]
    assert (scan.method, scan.settings) == (other.method, other.settings)
    read_already = load_scan(one | {"sampling": below})
    assert load_scan(read_already, {"sampling": above}) == other


PLANE = "bifurcation --set omega=7.7 --vary v2_0=-1:1:3 --record attractor"
BALL = "bifurcation --system bouncing-ball --vary x_0=-1:1:5"
PRESSED = "--system ssul-set6 --set C=-0.01"
TUNING = "tuning --system ssul-set6 --free k2=100:900 --impulse 10 --start 0,0,0.05,0"
HISTORIES = "response-history --system ssul-set6 --start 0,0,0.09,0 --vary C=0:0.02:5"
ONE = "ssul-set6: 1 of 1 starts is inside a wall, 10 mm deep at most"


@pytest.mark.parametrize(
    ("command", "line"),
    [
        (f"{PLANE} --vary x2_0=-0.06:0.1:5", "12 of 15 starts are inside a wall, 160 mm deep"),
        (f"{PLANE} --vary x2_0=0.1:0.26:5", ""),
        (f"{PLANE} --start 0,0,0.05,0", "3 of 3 starts are inside a wall, 50 mm deep at most"),
        (f"{PLANE} --start 0.01,0,0.1,0", "3 of 3 starts are inside a wall, 10 mm deep"),
        ("bifurcation --start random:50", ""),
        (
            "bifurcation --vary omega=7:8:11 --vary C=-0.01:0.01:3 --start both",
            "11 of 22 starts are inside a wall, 10 mm deep at most",
        ),
        (BALL, "2 of 5 starts are inside a wall and put on it, 1000 mm deep at most"),
        (f"portrait {PRESSED}", ONE),
        (f"response-history {PRESSED} --impulse 10", ONE),
        (HISTORIES, "ssul-set6: 5 of 5 starts are inside a wall, 10 mm deep at most"),
        (TUNING, "ssul-set6: 1 of 1 starts is inside a wall, 50 mm deep at most"),
        (f"response-curves {PRESSED} --vary omega=6:7:3", "Set 6: 3 of 3 starts are"),
    ],
)
def test_a_command_counts_starts_inside_a_wall_and_names_the_deepest(command, line, answer, here):
    text = answer(*command.split(), "--dry-run")
    lines = [one for one in text.splitlines() if "inside a wall" in one]
    assert len(lines) == bool(line)
    assert line in "".join(lines)


def test_the_line_is_that_of_the_states_of_the_kernels_where_there_is_a_wall():
    axes = {name: {"start": -0.3, "stop": 0.3, "num": 7} for name in ("x1_0", "x2_0")}
    for name in ("ssul-set6", "ssbl"):
        scan = load_scan(name, {"vary": axes, "set": {"omega": 7.0}})
        cells = scan.cells().ravel()
        where = np.unravel_index(np.arange(cells.size), scan.shape)
        states = given_states(cells, scan.start, scan.initial(where), scan.system.scene)
        depth = states[:, 2] - cells["near"]
        if "far" in scan.system.scene.walls:
            depth = np.maximum(depth, -states[:, 2] - cells["far"])
        (line,) = scan.starts_inside()
        most = f"{1e3 * depth.max():.4g} mm deep at most"
        assert line == f"{(depth > 1e-12).sum()} of 49 starts are inside a wall, {most}"
    # a scene without a wall has no start inside
    system = load_system("tmd")
    assert starts_inside(system, {}, {"x2": 1e9}) == []


def test_a_start_on_a_rigid_wall_is_on_it_however_far_the_structure_is_displaced(error_of):
    """A gap of 0.1 mm at 5 m: r = x1 - x2 + rest has the round-off of x1."""
    system = load_system("ssbl", law="restitution", D=1e-4, e=0.0)
    near, rest = float(system.cell.near), float(system.cell.rest)
    for x1 in np.linspace(-5.0, 5.0, 101):
        on_wall = x1, 0.0, x1 - near + rest, 0.0
        start_state(system, rest, on_wall)
        state = dict(zip(system.scene.components, on_wall, strict=True))
        assert starts_inside(system, {}, state) == []
    inside = 5.0, 0.0, 5.0 - near + rest - 1e-9, 0.0
    assert "inside the" in error_of(start_state, system, rest, inside)
