"""What every system answers, whether it is one of the paper's kinds or a host with dampers."""

import inspect

import numpy as np
import pytest

import nlds_vines as nv
from nlds_vines.errors import RequestError
from nlds_vines.model.catalog import told_apart
from nlds_vines.model.system import General, Preset

FRAME = nv.shear_frame([1e4] * 3, [8e6] * 3, ratio=0.02)
CELL = nv.Damper(
    "cell",
    attached_to="roof",
    m=900.0,
    k=2e4,
    walls=[nv.Wall(0.05, K=1e8), nv.Wall(0.02, "-", K=1e8)],
)
HOST = nv.System.from_host(FRAME, [CELL], force={"roof": 700.0}, omega=12.6)
SSBL = nv.load_system("ssbl")


@pytest.mark.parametrize("form", [Preset, General])
def test_each_form_answers_all_that_a_system_is_asked(form):
    unanswered = []
    for name, member in vars(nv.System).items():
        code = member.fget if isinstance(member, property) else member
        if inspect.isfunction(code) and "raise NotImplementedError" in inspect.getsource(code):
            unanswered += [name] * (name not in vars(form))
    assert unanswered == []
    assert issubclass(form, nv.System)


@pytest.mark.parametrize("system", [SSBL, HOST])
def test_signals_motions_and_forces_are_of_one_orbit(system):
    states = np.random.default_rng(1).normal(size=(5, len(system.scene.components))) * 0.1
    motions = system.motions()
    for motion in motions.bodies + motions.strokes:
        expected = states[:, ::2] @ motion.row
        np.testing.assert_allclose(motion.of(states), expected, atol=1e-15)
    for name in (*system.energy_signals, *system.force_signals, *system.usual_signals()):
        assert system.signal(name).of(states).shape == (5,)
    total = sum(system.contact_forces(states).values())
    np.testing.assert_array_equal(
        total, sum(system.signal(n).of(states) for n in system.force_signals)
    )
    np.testing.assert_array_equal(total, sum(system.contact_columns(states).values()))
    (force,) = system.harmonic_forces(np.array([0.0, system.period / 2])).values()
    np.testing.assert_allclose(force, force[0] * np.array([1.0, -1.0]))
    with pytest.raises(RequestError, match="nothing"):
        system.signal("nothing")


def test_what_the_user_set_is_told():
    assert SSBL.with_(P=600.0).changed_by_user == ("P",)
    changed = HOST.with_(**{"cell.gap": 0.03, "f": 2.0})
    assert changed.changed_by_user == ("cell.gap", "omega")
    assert changed.to_table()["sources"]["omega"] == "set by the user"
    assert changed.changes_from(HOST) == {"cell.gap": 0.03, "omega": 4.0 * np.pi}
    assert changed.has_parts_of(HOST)
    assert not changed.has_parts_of(HOST.alone())
    assert not changed.has_parts_of(SSBL)
    assert not SSBL.has_parts_of(nv.load_system("tmd"))


@pytest.mark.kernels
def test_a_table_of_an_orbit_has_the_forces_of_a_host():
    pytest.importorskip("pandas")
    orbit = nv.simulate(HOST, 1, samples=8, record=["trajectory"], quiet=True)
    frame = orbit.to_dataframe()
    assert [*frame][-2:] == ["force.roof", "cell.force"]
    assert frame.attrs["units"]["v_roof"] == "m/s"
    np.testing.assert_allclose(frame["force.roof"], 700.0 * np.cos(12.6 * frame["time"]))


def test_systems_side_by_side_are_told_apart(tmp_path):
    """By names of files, by what differs, and otherwise by numbers; one alone stays as it is."""
    table = (
        '[system]\nkind = "host"\nhost = { M = [[1.0]], K = [[1.0]] }\n'
        "force = { at = { x1 = 1.0 }, omega = 1.0 }\n"
    )
    files = [tmp_path / name for name in ("a.toml", "b.toml")]
    for file in files:
        file.write_text(table)
    first, second = (nv.load_system(file) for file in files)
    words = first.in_words()
    assert told_apart([first]) == (words,)
    assert told_apart([first, second]) == (f"{words} (a.toml)", f"{words} (b.toml)")
    tmd = nv.load_system("tmd")
    stronger = tmd.with_(P=900.0)
    assert told_apart([tmd, stronger, tmd, stronger]) == (
        "Tuned mass damper",
        "Tuned mass damper, P = 900 N",
        "Tuned mass damper [2]",
        "Tuned mass damper, P = 900 N [2]",
    )
    assert told_apart([tmd, nv.load_system("ssbl")]) == ("Tuned mass damper", "SSbl NES")
