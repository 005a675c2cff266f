"""From a cell of an archive to its orbit, the same to the last bit."""

import numpy as np
import pytest

import nlds_vines as nv
from nlds_vines.bifurcation.result import cell_orbit

pytestmark = pytest.mark.kernels

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
    folder, paths = tmp_path_factory.mktemp("cells"), {}

    def of(name):
        if name not in paths:
            scan = {**SCAN, "start": STARTS[name]}
            paths[name] = nv.scan(scan, to=folder / f"{name}.h5", quiet=True)
        return paths[name]

    return of


@pytest.mark.parametrize("name", STARTS)
def test_the_orbit_is_that_of_the_scan_to_the_last_bit(archive, name):
    with nv.read(archive(name)) as view:
        assert any("chaos" in label for label in view["label"].ravel())
        for i, omega in enumerate(view["omega"]):
            for j, K in enumerate(view["K"]):
                for k, start in enumerate(view["start"]):
                    orbit = nv.orbit_of(view, omega=omega, K=K, start=start)
                    section = view.take("section", omega=i, K=j, start=k)
                    assert np.array_equal(orbit.section, section)
                    assert orbit.system.parameters["omega"] == omega
                    assert orbit.system.K == K


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
    one = nv.orbit_of(archive("random"), omega=7.575, K=2.5e7, start=1)
    recorded = nv.orbit_of(
        archive("random"), omega=7.575, K=2.5e7, start=1, record=["section", "energy", "impacts"]
    )
    assert np.array_equal(one.section, recorded.section)
    assert recorded.E1max > 0


WRONG = {
    "outside": ({"omega": 8.5, "K": 3e7}, 0, "omega = 8.5 lies outside the scan: 7.3 to 7.575"),
    "missing": ({"omega": 7.5}, 0, "K is missing"),
    "unknown": ({"omega": 7.5, "k": 3e7}, 0, "varied parameter of .*: 'k'; allowed: omega, K"),
    "no such start": ({"omega": 7.5, "K": 3e7}, 3, "start = 3 must be .* 0 to 2"),
    "no such name": ({"omega": 7.5, "K": 3e7}, "up", "unknown start 'up'.*random 0"),
    "no number": ({"omega": "7.5", "K": 3e7}, 0, "must be a number"),
}


@pytest.mark.parametrize("case", WRONG)
def test_a_wrong_cell_is_one_line(archive, case):
    values, start, words = WRONG[case]
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
