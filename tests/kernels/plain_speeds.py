"""The section at impact of scans, beside the impacts of single orbits; kernels plain."""

import numpy as np
import pytest

import nlds_vines as nv
from nlds_vines.model.quantities import TOUCHES

CASES = {
    "hertz": ("ssul-set6", {}, (6.28, 7.4)),
    "two walls": ("ssbl", {"P": 2000.0}, (6.28, 7.0)),
    "restitution": ("ssul-set6", {"law": "restitution", "e": 0.7}, (6.28, 7.4)),
    "linear": ("ssul-set6", {"law": "linear", "kc": 1e6, "cc": 300.0}, (6.28, 7.4)),
}
TRANSIENT, PERIODS = 5, 6


def scanned(path, name, changes, values, want=("speeds", "impacts")):
    return nv.scan(
        {
            "system": name,
            "set": changes,
            "vary": {"omega": {"values": list(values)}},
            "sampling": {"transient": TRANSIENT, "periods": PERIODS},
            "record": {"want": list(want)},
        },
        to=path,
        quiet=True,
    )


@pytest.mark.parametrize("case", CASES)
def test_speeds_of_a_scan_are_those_of_its_orbits(case, tmp_path):
    """Notices: impacts of the transient, speeds in the wrong order, one wall left out."""
    name, changes, values = CASES[case]
    system = nv.load_system(name, **changes)
    archive = scanned(tmp_path / "speeds.h5", name, changes, values)
    with nv.read(archive) as view:
        column = view["impact_speed"]
        assert column.shape == (len(values), 1, TOUCHES * PERIODS)
        for i, value in enumerate(values):
            orbit = nv.simulate(
                system.with_(omega=value), PERIODS, transient=TRANSIENT, record=("impacts",)
            )
            speeds = orbit.impacts["speed"]
            assert len(speeds) > 0
            assert column[i, 0, : len(speeds)].tolist() == speeds.tolist()
            assert np.isnan(column[i, 0, len(speeds) :]).all()


@pytest.mark.parametrize("case", CASES)
def test_the_section_at_impact_is_that_of_the_orbits(case, tmp_path):
    """Notices: another period's phase, that of the release, walls in the wrong order."""
    name, changes, values = CASES[case]
    system = nv.load_system(name, **changes)
    archive = scanned(tmp_path / "touches.h5", name, changes, values, ["impact_section"])
    with nv.read(archive) as view:
        speeds, phases = view["impact_speed"][:, 0], view["impact_phase"][:, 0]
        assert speeds.shape == phases.shape == (len(values), TOUCHES * PERIODS)
        assert ("impact_wall" in view) == (name == "ssbl")
        for i, value in enumerate(values):
            there = system.with_(omega=value)
            impacts = nv.simulate(there, PERIODS, transient=TRANSIENT, record=("impacts",)).impacts
            count = len(impacts)
            assert count > 0
            assert speeds[i, :count].tolist() == impacts["speed"].tolist()
            apart = phases[i, :count] / (2 * np.pi) - impacts["touch"] / there.period
            assert np.abs(apart - np.round(apart)).max() < 1e-14 * (TRANSIENT + PERIODS)
            assert ((phases[i, :count] >= 0.0) & (phases[i, :count] < 2 * np.pi)).all()
            assert np.isnan(phases[i, count:]).all()
            if name == "ssbl":
                words = view.flags("impact_wall")
                codes = view["impact_wall"][i, 0]
                assert [words[code] for code in codes[:count].tolist()] == list(impacts["wall"])
                assert set(codes[:count].tolist()) == {0, 1}
                assert (codes[count:] == -1).all()


@pytest.mark.parametrize("case", [*CASES, "spring and stop"])
def test_modulation_is_that_of_the_orbits(case, tmp_path):
    """Notices: the amplitude without omega, periods with one impact or three, the transient."""
    name, changes, values = CASES.get(case, ("impact-oscillator", {}, (0.9, 2.6)))
    system = nv.load_system(name, **changes)
    archive = scanned(tmp_path / "modulation.h5", name, changes, values, ["modulation"])
    with nv.read(archive) as view:
        assert ("capture" in view) == (name == "ssbl")
        for i, value in enumerate(values):
            orbit = nv.simulate(
                system.with_(omega=value), PERIODS, transient=TRANSIENT,
                record=("section", "impacts"),
            )  # fmt: skip
            turns = orbit.impacts["touch"] * value / (2 * np.pi)
            counts = [
                sum(p <= turn < p + 1 for turn in turns)
                for p in range(TRANSIENT, TRANSIENT + PERIODS)
            ]
            sizes = [float(abs(complex(row[0], row[1] / value))) for row in orbit.section]
            assert view["amplitude_min"][i, 0] == pytest.approx(min(sizes), rel=1e-14)
            assert view["amplitude_max"][i, 0] == pytest.approx(max(sizes), rel=1e-14)
            assert view["two_impacts"][i, 0] == counts.count(2) / PERIODS
            if name == "ssbl":
                word = view.flags("capture")[int(view["capture"][i, 0])]
                rate = sum(counts) / PERIODS
                expected = "sustained_1_to_1" if rate == 2 else "strongly_modulated"
                assert word == (
                    "more_impacts" if rate > 2.01 else expected if rate else "no_impacts"
                )


def test_what_there_is_no_room_for_is_counted(tmp_path):
    """A damper that chatters: its first speeds are kept, all of its impacts are counted."""
    changes = {"law": "restitution", "e": 0.9, "C": 0.0, "c2": 0.0}
    archive = scanned(tmp_path / "chatter.h5", "ssul-set6", changes, (0.5, 6.28))
    with nv.read(archive) as view:
        counts = view["impact_rate"][:, 0] * PERIODS
        stored = np.isfinite(view["impact_speed"][:, 0]).sum(axis=-1)
    assert stored.tolist() == np.minimum(counts, TOUCHES * PERIODS).tolist()
    assert counts.max() > TOUCHES * PERIODS


def test_a_diagram_of_speeds_has_a_dot_for_each_impact(tmp_path):
    archive = scanned(tmp_path / "speeds.h5", "ssul-set6", {}, (6.2, 6.3, 7.4))
    with nv.read(archive) as view:
        speeds = view["impact_speed"][:, 0]
    (axes,) = [one for one in nv.plot(archive).axes if "speed" in one.get_ylabel()]
    assert axes.get_ylabel() == "approach speed [m/s]"
    drawn = np.concatenate([np.asarray(line.get_ydata(), float) for line in axes.lines])
    drawn = drawn[np.isfinite(drawn)]
    assert sorted(drawn) == sorted(speeds[np.isfinite(speeds)])


def test_a_scene_without_walls_has_no_speeds(tmp_path):
    with pytest.raises(nv.RequestError, match="no wall"):
        scanned(tmp_path / "tmd.h5", "tmd", {}, (6.0, 6.2))
