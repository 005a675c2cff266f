"""Orbits of scans from any state and phase of the force, and from the cells of their archives."""

from functools import cache

import numpy as np
import planes
import pytest

import nlds_vines as nv
from nlds_vines.bifurcation.command import start_of
from nlds_vines.bifurcation.result import cell_orbit
from nlds_vines.bifurcation.run import Computer
from nlds_vines.engine import batch
from nlds_vines.engine.batch import TURN, start_state
from nlds_vines.engine.solver_settings import chosen_settings
from nlds_vines.engine.starts import user_states
from nlds_vines.explore.map_data import stored
from nlds_vines.explore.page_state import Chosen
from nlds_vines.kernels.cells.cells import enter
from nlds_vines.kernels.scene.codes import DIVERGED

pytestmark = pytest.mark.kernels

SAMPLES = 48
CASES = {  # with impacts in the middle of periods
    "hertz": ("ssul-set6", {"omega": 5.5}),
    "soft": ("ssul-set6", {"K": 1e5, "omega": 4.0}),
    "two walls": ("ssbl", {}),
    "restitution": ("ssul-set6", {"law": "restitution", "e": 0.7, "omega": 5.5}),
    "sticking": ("impact-oscillator", {"omega": 0.3, "P": 1.6, "e": 0.3}),
    "linear": ("ssul-set6", {"law": "linear", "kc": 1e6, "cc": 50.0, "omega": 5.5}),
    "no wall": ("tmd", {}),
}
PERIODS = 12
PLANE = {
    **planes.PLANE,
    "title": "a plane of phases",
    "vary": {
        "phase": {"start": 0.0, "stop": TURN, "num": 16},
        "v_0": {"start": -3.0, "stop": 3.0, "num": 20},
    },
}


def at_section(system, states, phases, method="exact", **settings):
    """Return the states at the next section, in the user's coordinates."""
    cells = np.repeat(np.atleast_1d(system.cells()), len(states))
    rest = float(cells["rest"][0])
    starts = np.array([start_state(system, rest, state)[:4] for state in states])
    how = method, chosen_settings(method, settings)
    behind = batch.at_section(system.scene, how, cells, starts, np.asarray(phases))
    return user_states(cells, behind, system.scene)


@pytest.mark.parametrize("case", CASES)
def test_a_start_on_an_orbit_comes_to_the_orbits_next_section(case):
    """Also within contacts, and with impacts in between: every state of three periods is one."""
    name, changes = CASES[case]
    system = nv.load_system(name, **changes)
    walls = bool(system.scene.walls)
    record = ("section", "trajectory", *["impacts"] * walls)
    fine = {"tolerance": "fine", "quiet": True, "samples": SAMPLES, "record": record}
    orbit = nv.simulate(system, PERIODS, **fine)
    states = orbit.trajectory.reshape(PERIODS, SAMPLES, -1)
    size = np.abs(orbit.trajectory).max(axis=0)
    phases = TURN * np.arange(1, SAMPLES) / SAMPLES
    chosen = range(PERIODS - 3, PERIODS)
    if walls and case != "sticking":
        touches = orbit.impacts["touch"] / system.period
        middle = (touches % 1 > 0.2) & (touches % 1 < 0.8)
        chosen = np.unique(touches[middle].astype(int))[:3].tolist()
        assert len(chosen) == 3
    if case in ("soft", "sticking"):
        times = system.period * (np.arange(1, PERIODS * SAMPLES) / SAMPLES)
        inside = [(times > one["touch"]) & (times < one["release"]) for one in orbit.impacts]
        assert np.any(inside, axis=0).sum() >= 3
    for period in chosen:
        section = at_section(system, states[period, :-1], phases, tolerance=1e-12)
        assert np.abs((section - orbit.section[period]) / size).max() < 1e-11


def test_the_method_rk4_begins_at_a_phase_too():
    system = nv.load_system("impact-oscillator", omega=1.5, P=2.0)
    orbit = nv.simulate(system, 1, record=("trajectory", "section"), samples=SAMPLES, quiet=True)
    phases = TURN * np.arange(1, SAMPLES) / SAMPLES
    states = orbit.trajectory[:-1]
    errors = [
        np.abs(at_section(system, states, phases, "rk4", period_steps=n) - orbit.section[0]).max()
        for n in (128, 256)
    ]
    assert 0 < errors[1] < errors[0] / 12  # order four
    assert errors[1] < 1e-6


def test_what_is_at_a_section_stays_there_and_what_does_not_come_so_far_diverges():
    system, state = nv.load_system("impact-oscillator", omega=1.5), [[0.3, -0.2]] * 2
    assert at_section(system, state, [0.0, TURN]).tolist() == state
    near = at_section(system, state, [np.nextafter(TURN, 0.0), TURN - 1e-9])
    assert np.allclose(near, state, atol=1e-8)
    # an orbit that does not come so far diverges
    system = nv.load_system("impact-oscillator", omega=1.5, P=0.0, c=0.0)
    assert np.isnan(at_section(system, [[-4.9e149, 0.0]], [TURN - 1.178])).all()
    document = {**PLANE, "system": system, "set": {}, "record": {"want": ["attractor", "energy"]}}
    document["vary"] = {"phase": {"values": [TURN - 1.178]}}
    scan = nv.load_scan({**document, "start": {"state": [-4.9e149, 0.0]}})
    arrays = Computer(scan).lanes(*Computer(scan).orbits(np.array([0])))
    assert arrays["status"].ravel().tolist() == [DIVERGED]


@pytest.fixture(scope="module")
def plane(tmp_path_factory):
    return nv.scan(PLANE, to=tmp_path_factory.mktemp("phases") / "plane.h5", quiet=True)


def test_a_plane_of_phases_has_the_basins_of_plain_following(plane):
    """From each cell an orbit is followed by `simulate`, after a first part on its own."""
    with nv.read(plane) as view:
        attractor, label = view["attractor"][..., 0], view["label"][..., 0]
        phases, speeds = view["phase"], view["v_0"]
        assert view["attractor_label"].tolist() == ["T,0", "T,1"]
    assert {0, 1} == set(attractor.ravel().tolist())
    # both ends are phase zero, where nothing is flown
    assert (attractor[0] == attractor[-1]).all()
    system = nv.load_system("impact-oscillator", omega=1.5, P=0.6)
    for i in (0, 5, 11):
        states = np.array([[0.0, v] for v in speeds])
        there = at_section(system, states, np.full(len(speeds), phases[i]))
        labels = [nv.classify(system, start=tuple(y), quiet=True).label for y in there]
        assert labels == label[i].tolist()


def test_an_archive_knows_its_phases(plane, tmp_path, answer):
    assert "results are the same" in answer("rerun", plane, "-o", tmp_path / "again.h5")
    orbit = nv.orbit_of(plane, phase=2.0, v_0=-1.2, quiet=True)
    cell = cell_orbit(plane, {"phase": 2.0, "v_0": -1.2})
    with nv.read(plane) as view:
        i, j = (np.abs(view[n] - x).argmin() for n, x in (("phase", 2.0), ("v_0", -1.2)))
        phase, speed = float(view["phase"][i]), float(view["v_0"][j])
        label = str(view["label"][i, j, 0])
    there = at_section(orbit.system, [[0.0, speed]], [phase])
    assert cell.begin.state[:2].tolist() == there[0].tolist()
    assert nv.classify(orbit.system, start=tuple(there[0]), quiet=True).label == label
    # an attractor's point is at phase zero: how far a basin is left lies in no such plane
    assert all(not basin.nearest for basin in nv.basin_measures(plane).basins)
    # the page begins there as well, and its slider moves the phase
    page = stored(plane)
    start = page.start_of((i, j), 0, orbit.system)
    assert start.state == tuple(there[0].tolist())
    assert start.words == f"phase = {phase:g}, v_0 = {speed:g}"
    chosen = Chosen(page)
    chosen.choose((i, j), 0)
    chosen.free["phase"] = 1.0
    moved = at_section(orbit.system, [[0.0, speed]], [1.0])
    assert chosen.begins(orbit.system).state == tuple(moved[0].tolist())


def test_phases_of_starts_and_axes_are_the_same_and_phase_zero_compiles_nothing(answer, here):
    along = {**PLANE, "vary": {"v_0": PLANE["vary"]["v_0"]}, "record": {"want": ["section"]}}
    both = {**along, "vary": {"phase": {"values": [1.25]}, **along["vary"]}}
    scan = nv.load_scan({**along, "start": {"policy": "rest", "phase": 1.25}})
    assert nv.load_scan(scan.document()) == scan
    one, two = nv.scan(scan, quiet=True), nv.scan(both, quiet=True)
    with one.read() as view, two.read() as other:
        assert np.array_equal(view["section"], other["section"][0])
    state = nv.load_scan({**along, "start": {"state": [0.1, 0.2], "phase": 1.25}})
    assert (state.start.state, state.start.phase) == ((0.1, 0.2), 1.25)
    assert "phase" not in nv.load_scan(along).document()["start"]
    # a scan at phase zero compiles nothing for phases
    before = len(getattr(enter, "signatures", ()))
    nv.scan(along, quiet=True)
    assert len(getattr(enter, "signatures", ())) == before
    # the command takes phases
    assert start_of("rest@1.5") == {"start": {"policy": "rest", "phase": 1.5}}
    state = {"policy": "state", "state": [0.1, 0.0], "phase": 1.5}
    assert start_of("0.1,0@1.5") == {"start": state}
    vary = ["--vary", "phase=0:6:3", "--vary", "v_0=-1:1:4", "--record", "attractor"]
    command = ["bifurcation", "--system", "impact-oscillator", *vary, "--dry-run"]
    assert "12 (3 x 4 cells" in answer(*command)


# ---- from a cell of an archive ----

SCAN = {
    "system": "ssul-set6",
    "vary": {"omega": {"values": [7.3, 7.5, 7.575]}, "K": {"values": [2.5e7, 3e7]}},
    "sampling": {"transient": 150, "periods": 40},
    "record": {"want": ["section", "regime"]},
}
STARTS = {
    "random": {"policy": "random", "count": 3, "seed": 4},
    "rest": {"policy": "rest"},
    "both": {"policy": "both"},
}


@pytest.fixture(scope="module")
def archive(tmp_path_factory):
    """Return a function that computes the scan from some starts, once."""
    folder = tmp_path_factory.mktemp("cells")

    @cache
    def of(name):
        return nv.scan({**SCAN, "start": STARTS[name]}, to=folder / f"{name}.h5", quiet=True)

    return of


@pytest.mark.parametrize("name", STARTS)
def test_the_orbit_is_that_of_the_scan_to_the_last_bit(archive, name):
    with nv.read(archive(name)) as view:
        assert any("chaos" in label for label in view["label"].ravel())
        for i, j, k in np.ndindex(view["label"].shape):
            omega, K, start = view["omega"][i], view["K"][j], view["start"][k]
            orbit = nv.orbit_of(view, omega=omega, K=K, start=start)
            assert np.array_equal(orbit.section, view.take("section", omega=i, K=j, start=k))
            assert (orbit.system.parameters["omega"], orbit.system.K) == (omega, K)


def test_the_states_that_were_drawn_are_stored(archive):
    with nv.read(archive("random")) as view:
        states = view["start_state"]
        assert view.dims("start_state") == ("omega", "K", "start", "component")
        assert np.isfinite(states).all()
        assert len(np.unique(states[0, 1], axis=0)) == 3
        for start in range(3):
            orbit = nv.orbit_of(view, omega=7.3, K=3e7, start=start)
            again = nv.simulate(orbit.system, 40, transient=150, start=states[0, 1, start])
            np.testing.assert_allclose(again.section, orbit.section, rtol=0, atol=1e-9)
    with nv.read(archive("rest")) as view:
        assert "start_state" not in view


def test_the_orbit_of_a_portrait_or_of_the_nearest_cell_is_that_of_the_scan(archive):
    cell = cell_orbit(archive("random"), {"omega": 7.575, "K": 2.5e7}, 1)
    orbit = cell.orbit()
    traced = cell.traced(150, 190, 32)
    assert np.array_equal(traced.trajectory[31::32], orbit.section)
    assert np.array_equal(traced.impacts["touch"], orbit.impacts["touch"])
    assert traced.time[-1] == pytest.approx(190 * cell.begin.system.period, rel=1e-12)
    steps = np.abs(np.diff(traced.trajectory[:, 0])).max()
    assert steps < np.ptp(traced.trajectory[:, 0]) / 4  # no jump where two periods meet
    # the nearest cell is taken
    near = nv.orbit_of(archive("rest"), omega=7.42, K=2.6e7)
    assert near.system.parameters["omega"] == 7.5
    assert near.system.K == 2.5e7
    # other records change no bit
    at, record = {"omega": 7.575, "K": 2.5e7, "start": 1}, ["section", "energy", "impacts"]
    recorded = nv.orbit_of(archive("random"), **at, record=record)
    assert np.array_equal(orbit.section, recorded.section)
    assert recorded.E1max > 0


@pytest.mark.parametrize(
    ("values", "start", "words"),
    [
        ({"omega": 8.5, "K": 3e7}, 0, "omega = 8.5 lies outside the scan: 7.3 to 7.575"),
        ({"omega": 7.5}, 0, "K is missing"),
        ({"omega": 7.5, "k": 3e7}, 0, "varied parameter of .*: 'k'; allowed: omega, K"),
        ({"omega": 7.5, "K": 3e7}, 3, "start = 3 must be .* 0 to 2"),
        ({"omega": 7.5, "K": 3e7}, "up", "unknown start 'up'.*random 0"),
        ({"omega": "7.5", "K": 3e7}, 0, "must be a number"),
    ],
)
def test_a_wrong_cell_is_one_line(archive, values, start, words):
    with pytest.raises(nv.RequestError, match=words):
        nv.orbit_of(archive("random"), start=start, **values)


def test_the_command_draws_a_cell(archive, here, answer, refusal):
    file, at = str(archive("random")), ["--at", "omega=7.5,K=3e7"]
    out = answer("portrait", file, *at, "--start", "random 2", "--samples", "64")
    assert out.startswith("SSul NES, Set 6, K = 3e+07")
    assert "start random 2" in out
    assert "periods 150 to 190" in out
    name = "random-omega=7.5-K=3e7-start=random_2.png"  # not that of the map's own picture
    assert (here / name).stat().st_size > 0
    for options, words in (
        (["--set", "P=700"], "set beside an archive"),
        (["--tolerance", "1e-6"], "tolerance beside an archive"),
        (["--start", "0,0,0,0"], "unknown start '0,0,0,0'"),
    ):
        assert words in refusal("portrait", file, *at, *options)
    assert "give the archive" in refusal("portrait", "--at", "omega=7")
