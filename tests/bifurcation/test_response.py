"""A response and a ground that moves, in scans, tunings and Python: every entrance, bad input."""

import numpy as np
import pytest

from nlds_vines import System, load_scan, load_system, load_tuning, read, simulate, tune
from nlds_vines.engine.responses import arrays_of, objectives_of, quantities_of
from nlds_vines.kernels.scene.codes import RESPONSE_COLUMNS
from nlds_vines.model.quantities import BY_NAME
from nlds_vines.model.scenes import scene_of
from paper.linear import response
from scans import computed, scan_of

OMEGAS = [6.0, 6.28]
BASE = {"base_displacement": 0.01}


def request_of(system="tmd", vary=None, changes=None):
    vary = vary or {"omega": OMEGAS}
    return scan_of(system, ("response", "section"), vary, changes=changes, transient=30, periods=4)


def force_of(system, omega, Y):
    return system.structure[0] * Y * omega * omega


@pytest.mark.kernels
def test_a_scan_records_what_simulate_returns_and_nothing_of_a_failed_orbit():
    scan = request_of()
    arrays = computed(scan)
    for i, omega in enumerate(OMEGAS):
        orbit = simulate(load_system("tmd", omega=omega), 4, transient=30, record=("response",))
        assert orbit.response.keys() <= arrays.keys()
        for name, value in orbit.response.items():
            assert arrays[name][i, 0] == value, name
            assert scan.table.datasets[name].units
            assert len(scan.table.datasets[name].long_name) > 10
        # a reduction compares with the structure alone
        alone = abs(response(load_system("none"), np.array([omega])).X1[0])
        for power, name in enumerate(("x1", "v1", "a1")):
            largest = alone * omega**power
            reduction = 1 - arrays[f"{name}_max"][i, 0] / largest
            assert arrays[f"{name}_max_reduction"][i, 0] == pytest.approx(reduction, abs=1e-14)
            reduction = 1 - arrays[f"{name}_rms"][i, 0] / (largest * np.sqrt(0.5))
            assert arrays[f"{name}_rms_reduction"][i, 0] == pytest.approx(reduction, abs=1e-14)
    # numbers whose squares are beyond all numbers: an orbit that is not followed at all
    arrays = computed(request_of(vary={"P": [800.0, 1e200]}))
    assert (arrays["status"][:, 0] == 0).tolist() == [True, False]
    assert np.isfinite(arrays["x1_rms"][:, 0]).tolist() == [True, False]


def test_what_is_recorded_depends_on_what_the_scene_has():
    for scene, there, missing in (
        ("none", {"x1_max"}, {"stroke_max", "power_c2"}),
        ("tmd", {"stroke_max", "power_c2"}, {"force_max"}),
        ("ssbl", {"force_max", "power_contact"}, set()),
        ("ssbl/restitution", {"impulse_max"}, {"force_max", "a1_max"}),
    ):
        names = {quantity.name for quantity in quantities_of(scene_of(scene))}
        assert there <= names
        assert not missing & names
    two = request_of("ssbl").table
    assert two.datasets["force_max"].dims[-1] == "wall"
    assert request_of("ssul-set6").table.datasets["force_max"].dims == ("omega", "start")


@pytest.mark.kernels
def test_a_tuning_makes_any_number_of_a_response_small(tmp_path):
    free = {"c2": {"low": 50.0, "high": 500.0}, "k2": {"low": 1000.0, "high": 3000.0}}
    over = {"omega": {"values": [5.5, 6.28]}}
    search = {"population": 5, "generations": 2, "polish": 5, "optima": 1, "objective": "a1_rms"}
    tuned = tune(
        "tmd", tmp_path / "a.h5", free=free, over=over, search=search, plot=tmp_path / "a.png",
        surface={"parameters": ["c2", "k2"], "size": 3},
    )  # fmt: skip
    systems = [load_system("tmd", **tuned.parameters, omega=omega) for omega in (5.5, 6.28)]
    orbits = [simulate(s, 2, transient=300, record=("response",)) for s in systems]
    assert tuned.objective == pytest.approx(max(o.response["a1_rms"] for o in orbits), rel=1e-12)
    assert tuned.tuning.search.objective == "a1_rms"
    assert "a1_rms [m/s^2]" in "\n".join(tuned.lines())
    with read(tmp_path / "a.h5") as view:
        assert view.units("objective") == view.units("surface") == "m/s^2"
        assert "a1_rms" in view.long_name("objective")


def test_the_objective_belongs_to_the_request_of_a_tuning_and_must_exist(answer, refusal):
    plain = load_tuning("tmd")
    assert plain.document()["search"]["objective"] == "E1max"
    assert load_tuning(plain.document()).hash == plain.hash
    other = load_tuning("tmd", {"search": {"objective": "x1_max"}})
    assert other.hash != plain.hash
    assert load_tuning(other.document()) == other
    words = "tuning", "--system", "tmd", "--dry-run", "--objective"
    error = refusal(*words, "force_max")
    assert "'force_max'" in error
    assert "a1_rms" in error
    assert "a1_rms: one orbit, from rest" in answer(*words, "a1_rms")


def test_all_ways_to_give_the_ground_mean_the_same():
    by_name = load_system("ssul-set6", base_displacement=0.01)
    by_table = load_system("ssul-set6", P={"base_displacement": 0.01})
    assert by_name.parameters == by_table.parameters
    assert "P" not in by_name.parameters
    assert by_name.force == pytest.approx(force_of(by_name, 6.28, 0.01), rel=1e-15)
    # Y cos(omega t) is accelerated by -omega^2 Y cos(omega t)
    shaken = load_system("ssul-set6", base_acceleration=0.01 * 6.28**2)
    assert shaken.force == pytest.approx(-by_name.force, rel=1e-15)
    back = by_name.with_(P=800.0)
    assert back.parameters == load_system("ssul-set6").parameters
    words = {"Y": 0.1, "base_displacement": 0.1}
    one, two = (load_system("impact-oscillator", **{k: v}) for k, v in words.items())
    assert one.cells() == two.cells()
    a = 0.1 * one.parameters["omega"] ** 2
    by_acceleration = load_system("impact-oscillator", base_acceleration=a)
    assert by_acceleration.force == pytest.approx(-one.force, rel=1e-15)
    ball = load_system("bouncing-ball")
    same = ball.with_(base_displacement=ball.parameters["Y"])
    assert same.cells() == ball.cells()


@pytest.mark.kernels
def test_the_force_follows_what_it_depends_on():
    vary = {"omega": {"values": OMEGAS}, "k1": {"values": [3e4, 4e4]}}
    scan = request_of(vary=vary, changes={"P": BASE})
    arrays = computed(scan)
    for i, omega in enumerate(OMEGAS):
        for j, k1 in enumerate((3e4, 4e4)):
            force = force_of(load_system("tmd", k1=k1), omega, 0.01)
            assert arrays["P"][i, j, 0] == pytest.approx(force, rel=1e-15)
            orbit = simulate(load_system("tmd", k1=k1, omega=omega, **BASE), 4, transient=30)
            assert np.array_equal(arrays["section"][i, j, 0], orbit.section)
    assert scan.system.attributes()["base_displacement"] == 0.01
    assert load_scan(scan.document()).hash == scan.hash


@pytest.mark.kernels
@pytest.mark.parametrize("system", ["tmd", load_system("tmd", **BASE)])
def test_the_motion_of_the_ground_may_vary_itself(system):
    values = [0.005, 0.01]
    arrays = computed(request_of(system, {"base_displacement": {"values": values}}))
    twice = arrays["x1_abs_max"][:, 0]
    assert twice[1] == pytest.approx(2 * twice[0], rel=1e-12)
    assert arrays["transmissibility"][0, 0] == pytest.approx(arrays["transmissibility"][1, 0])
    alone = computed(request_of("tmd", {"omega": {"values": [6.28]}}, changes=BASE))
    assert alone["x1_abs_max"][0, 0] == arrays["x1_abs_max"][1, 0]
    force = computed(request_of(load_system("tmd", **BASE), {"P": {"values": [700.0, 800.0]}}))
    assert "x1_abs_max" not in force
    assert force["x1_max"][1, 0] == pytest.approx(8 / 7 * force["x1_max"][0, 0])


def test_a_tuning_of_a_shaken_structure_follows_omega():
    tuning = load_tuning("tmd", {"set": {"base_acceleration": 1.0}})
    assert "transmissibility" in objectives_of(tuning.system, tuning.system.scene, "")
    cells = tuning.system.cells({"omega": np.array(OMEGAS)})
    np.testing.assert_allclose(cells["P"], [-1000.0, -1000.0], rtol=1e-15)
    cells = load_system("tmd", **BASE).cells({"omega": np.array(OMEGAS)})
    expected = [force_of(tuning.system, omega, 0.01) for omega in OMEGAS]
    np.testing.assert_allclose(cells["P"], expected, rtol=1e-15)
    over = {"over": {"base_displacement": {"values": [0.01, 0.02]}}}
    assert load_tuning("tmd", over).system.scene.shaken == "base_displacement"


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"P": 800.0, **BASE}, "P beside base_displacement"),
        ({**BASE, "base_acceleration": 1.0}, "base_displacement beside base_acceleration"),
        ({"base_displacement": -0.01}, "base_displacement = -0.01 is not allowed"),
        ({"base_acceleration": float("nan")}, "base_acceleration"),
        ({"P": {}}, "must have one key"),
        ({"P": {"base": 1.0}}, "'base'"),
        ({"P": {**BASE, "base_acceleration": 1.0}}, "must have one key"),
        ({"P": BASE, **BASE}, "give it once"),
        ({"P": {"base_displacement": "far"}}, "base_displacement"),
        ({"base_displacement": 1e308}, "not finite"),
        ({"Y": 0.1}, "has no parameter 'Y'"),
    ],
)
def test_a_ground_that_cannot_be_is_refused_in_one_line(changes, message, error_of):
    assert message in error_of(load_system, "tmd", **changes)
    together = {"P": [1.0, 2.0], "base_displacement": [0.0, 1.0]}
    assert "P beside base_displacement" in error_of(request_of, vary=together)


def test_round_off_carries_no_displacement_beyond_a_rigid_stop():
    numbers = {"m": 1.0, "k": 1.0, "c": 0.1, "C": 0.7, "C_2": 1.0, "P": 0.6, "omega": 1.0, "e": 0.8}
    system = System("oscillator-2", numbers, law="restitution")
    cells = np.repeat(np.atleast_1d(system.cells()), 4)
    rows = np.zeros((4, RESPONSE_COLUMNS))
    rows[:, 0] = 0.7 + 4e-15, 1.0 + 5e-15, 0.7 - 5e-15, 0.71
    largest = arrays_of(rows, system.scene, cells)["x1_max"]
    assert largest.tolist() == [0.7, 1.0, 0.7, 0.71]


def test_datasets_say_their_frame_which_the_motion_of_the_ground_changes():
    """Positions, velocities and energies are relative to moving ground, accelerations absolute."""
    shaken = load_system("tmd", base_displacement=0.01).scene
    oscillator, force = load_system("impact-oscillator", Y=0.1).scene, load_system("tmd").scene
    for name in ("x1_max", "v1_rms", "E1max", "E2max", "section"):
        for scene in (shaken, oscillator):
            assert "relative to the ground" in BY_NAME[name].words_in(scene), name
        assert not {"absolute", "relative"} & set(BY_NAME[name].words_in(force).split())
    for scene in (shaken, oscillator, force):
        assert "absolute" in BY_NAME["a1_max"].words_in(scene)
    assert "absolute displacement" in BY_NAME["x1_abs_max"].words_in(shaken)
    # an axis of the ground's motion changes the frame
    system = load_system("impact-oscillator")
    systems = system, system.with_axes(["Y"]), system.with_axes(["Y"]).with_axes(["P"])
    assert [one.scene.shaken for one in systems] == ["", "Y", ""]
    assert load_system("bouncing-ball").scene.shaken == "Y"
