"""Sweeps and records of impacts of scans, cell by cell against `simulate`."""

import numpy as np
import pytest

import nlds_vines as nv
from nlds_vines.engine.batch import parts_of, run
from nlds_vines.kernels.scene.codes import OK, TOO_STIFF
from nlds_vines.kernels.scene.scene import LaneBuffers, Span
from nlds_vines.model.quantities import TOUCHES
from scans import computed, scan_of

TRANSIENT, PERIODS = 1, 2
STEPS = 64  # of a period by rk4: the sweep and the single orbits err alike
RECORD = ("section", "impacts", "energy", "clearance")
LINKS = [(50.0, 0.1), (1e12, 0.2), (60.0, 0.3)]  # dashpot and place of the wall; one is too stiff
SWEEPS = {
    # what varies, and its values: the damper is pressed onto another wall, or lies beyond it
    "ssbl, D": ("ssbl", "D", [0.01, 0.03, 0.05, 0.06]),
    "ssbl, C": ("ssbl", "C", [0.01, 0.03, 0.05, 0.06]),
    "ssul, C": ("ssul-set6", "C", [-0.005, 0.0, 0.02, 0.05]),
    "ssul, V": ("ssul-set6", "V", [0.05, 0.1, 0.15, 0.3]),
    "a linear damper, k2": ("tmd", "k2", [300.0, 600.0, 900.0, 1200.0]),
}


@pytest.mark.parametrize(("policy", "method"), [("up", "exact"), ("down", "rk4")])
@pytest.mark.parametrize("case", SWEEPS)
def test_every_link_begins_where_the_one_before_ended(case, policy, method):
    name, parameter, values = SWEEPS[case]
    walls = bool(nv.load_system(name).scene.walls)
    record = RECORD if walls else ("section", "energy")
    sampling = {"transient": TRANSIENT, "periods": PERIODS, "method": method}
    sampling |= {"period_steps": STEPS} if method == "rk4" else {}
    arrays = computed(scan_of(name, record, {parameter: values}, policy, **sampling))
    assert (arrays["status"] == OK).all()
    state = None
    for i in range(4) if policy == "up" else reversed(range(4)):
        system = nv.load_system(name, **{parameter: values[i]})
        orbit = nv.simulate(system, start=state, record=record, **sampling)
        state = orbit.state
        np.testing.assert_allclose(arrays["section"][i, 0], orbit.section, rtol=0, atol=1e-10)
        assert arrays["E1max"][i, 0] == pytest.approx(orbit.E1max, rel=1e-8)
        assert arrays["E2max"][i, 0] == pytest.approx(orbit.E2max, rel=1e-8)
        if walls:
            assert arrays["impact_rate"][i, 0] * PERIODS == len(orbit.impacts)
            assert arrays["clearance"][i, 0] == pytest.approx(orbit.clearance, abs=1e-10)


def test_after_a_link_that_failed_the_next_begins_at_rest():
    """At its own rest, wherever that of the link before was, and whatever moved before that."""
    systems = [nv.load_system("ssul-set6", c2=c2, V=V) for c2, V in LINKS]
    cells = np.array([[system.cells() for system in systems]])
    section, status = np.zeros((1, 3, PERIODS, 4)), np.array([[OK, TOO_STIFF, OK]])
    buffers = LaneBuffers(section=section)
    parts, span = parts_of("exact", systems[0].scene), Span(TRANSIENT, PERIODS, 1)
    np.testing.assert_array_equal(run(parts, cells, np.zeros((1, 4)), span, buffers), status)
    for i in (0, 2):
        alone = nv.simulate(systems[i], PERIODS, transient=TRANSIENT)
        np.testing.assert_allclose(section[0, i], alone.section, rtol=0, atol=1e-10)


SYSTEMS = {
    "hertz": ("ssul-set6", {}, (6.28, 7.4)),
    "two walls": ("ssbl", {"P": 2000.0}, (6.28, 7.0)),
    "restitution": ("ssul-set6", {"law": "restitution", "e": 0.7}, (6.28, 7.4)),
    "linear": ("ssul-set6", {"law": "linear", "kc": 1e6, "cc": 300.0}, (6.28, 7.4)),
    "spring and stop": ("impact-oscillator", {}, (0.9, 2.6)),
}
BEFORE, NOTED = 5, 6


def scanned(path, name, changes, values, want=("speeds", "impacts")):
    sampling = {"transient": BEFORE, "periods": NOTED}
    scan = scan_of(name, want, {"omega": values}, changes=changes, **sampling)
    return nv.scan(scan, to=path, quiet=True)


@pytest.mark.parametrize("case", SYSTEMS)
def test_impacts_and_modulation_of_a_scan_are_those_of_its_orbits(case, tmp_path):
    """Notices: impacts of the transient or in the wrong order, one wall left out, the phase of
    another period or of the release; the amplitude without omega, periods with one impact or three.
    """
    name, changes, values = SYSTEMS[case]
    want = ["impacts", "impact_section", "modulation"]
    with nv.read(scanned(tmp_path / "touches.h5", name, changes, values, want)) as view:
        speeds, phases = view["impact_speed"][:, 0], view["impact_phase"][:, 0]
        assert speeds.shape == phases.shape == (len(values), TOUCHES * NOTED)
        assert ("impact_wall" in view) == ("capture" in view) == (name == "ssbl")
        for i, value in enumerate(values):
            system = nv.load_system(name, **changes, omega=value)
            orbit = nv.simulate(system, NOTED, transient=BEFORE, record=("section", "impacts"))
            impacts, turns = orbit.impacts, orbit.impacts["touch"] / system.period
            count = len(impacts)
            assert count > 0 or name == "impact-oscillator"
            assert view["impact_rate"][i, 0] * NOTED == pytest.approx(count)
            assert speeds[i, :count].tolist() == impacts["speed"].tolist()
            apart = phases[i, :count] / (2 * np.pi) - turns
            assert np.abs(apart - np.round(apart)).max(initial=0.0) < 1e-14 * (BEFORE + NOTED)
            assert ((phases[i, :count] >= 0.0) & (phases[i, :count] < 2 * np.pi)).all()
            assert np.isnan([speeds[i, count:], phases[i, count:]]).all()
            counts = [np.count_nonzero(turns // 1 == p) for p in range(BEFORE, BEFORE + NOTED)]
            sizes = np.hypot(orbit.section[:, 0], orbit.section[:, 1] / value)
            assert view["amplitude_min"][i, 0] == pytest.approx(sizes.min(), rel=1e-14)
            assert view["amplitude_max"][i, 0] == pytest.approx(sizes.max(), rel=1e-14)
            assert view["two_impacts"][i, 0] == counts.count(2) / NOTED
            if name == "ssbl":
                words = view.flags("impact_wall")
                codes = view["impact_wall"][i, 0]
                assert [words[code] for code in codes[:count].tolist()] == list(impacts["wall"])
                assert set(codes[:count].tolist()) == {0, 1}
                assert (codes[count:] == -1).all()
                word = view.flags("capture")[int(view["capture"][i, 0])]
                expected = "sustained_1_to_1" if count == 2 * NOTED else "strongly_modulated"
                assert word == (
                    "more_impacts" if count > 2.01 * NOTED else expected if count else "no_impacts"
                )


def test_what_there_is_no_room_for_is_counted(tmp_path):
    """A damper that chatters: its first speeds are kept, all of its impacts are counted."""
    changes = {"law": "restitution", "e": 0.9, "C": 0.0, "c2": 0.0}
    archive = scanned(tmp_path / "chatter.h5", "ssul-set6", changes, (0.5, 6.28))
    with nv.read(archive) as view:
        counts = view["impact_rate"][:, 0] * NOTED
        speeds = view["impact_speed"][:, 0]
    stored = np.isfinite(speeds).sum(axis=-1)
    assert stored.tolist() == np.minimum(counts, TOUCHES * NOTED).tolist()
    assert counts.max() > TOUCHES * NOTED
    system = nv.load_system("ssul-set6", **changes, omega=0.5)
    impacts = nv.simulate(system, NOTED, transient=BEFORE, record=("impacts",)).impacts
    assert speeds[0].tolist() == impacts["speed"][: TOUCHES * NOTED].tolist()


def test_a_diagram_of_speeds_has_a_dot_for_each_impact(tmp_path, error_of):
    archive = scanned(tmp_path / "speeds.h5", "ssul-set6", {}, (6.2, 6.3, 7.4))
    with nv.read(archive) as view:
        speeds = view["impact_speed"][:, 0]
    (axes,) = [one for one in nv.plot(archive).axes if "speed" in one.get_ylabel()]
    assert axes.get_ylabel() == "approach speed [m/s]"
    drawn = np.concatenate([np.asarray(line.get_ydata(), float) for line in axes.lines])
    assert sorted(drawn[np.isfinite(drawn)]) == sorted(speeds[np.isfinite(speeds)])
    assert "no wall" in error_of(scanned, tmp_path / "tmd.h5", "tmd", {}, (6.0, 6.2))
