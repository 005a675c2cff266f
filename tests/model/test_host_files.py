"""Systems of hosts in request files: exact copies, every way to state a host, refusals."""

import copy
import functools
import math
import pickle
import re
import tomllib

import numpy as np
import pytest
from support import REPO

import nlds_vines as nv
from nlds_vines.archives.files import toml_text
from nlds_vines.model.catalog import any_system_from
from nlds_vines.model.host import host_from, table_of

FRAME = nv.shear_frame([1e4, 1.1e4, 0.9e4], [8e6, 7e6, 6e6], ratio=[0.02, 0.03])
COUPLED = np.array([[3.0, -1.0, 0.0], [-1.0, 2.0, -1.0], [0.0, -1.0, 1.0]])
HOSTS = {
    "ratios": FRAME,
    "undamped": nv.chain([1.0, 2.0], [3.0, 4.0, 5.0]),
    "consistent mass": nv.beam(1.0, 65.6, 1.18, elements=3, rayleigh=(0.1, 1e-5)),
    "damping by matrix": nv.Host(FRAME.M, FRAME.K, 1e3 * COUPLED, influence=[1.0, 0.5, 0.0]),
    "reduced": FRAME.reduced(1, statics=["roof"]),
    "reduced, coupled": nv.Host(FRAME.M, FRAME.K, 1e3 * COUPLED).reduced(2),
    "modes": nv.Host.from_modes(
        [{"f": 1 / 3, "zeta": 0.01, "shape": {"tip": 2.0, "mid": 0.1}, "participation": 0.3}]
    ),
}
LIGHT = np.diag([1e4, 1.1e4, 0.0, 0.9e4]), 1e6 * (4 * np.eye(4) - np.ones((4, 4)) / 2)
NODES = nv.Host(*LIGHT, ratio="1%", dofs=[1, 2, 3, 4], influence=[1, 1, 1, 0], condense=True)
HOSTS |= {"condensed": NODES, "condensed and reduced": NODES.reduced(2)}
FILE = """
title = "A frame"
[system]
kind = "host"
title = "a frame with a cell and a stop"
[system.host]
shear_frame = { masses = [1e4, 1e4, 1e4], stiffnesses = [8e6, 8e6, 8e6] }
ratio = 0.01
[[system.dampers]]
name = "cell"
attached_to = "roof"
m = 300
law = "hertz"
K = 3e7
walls = [{ gap = 0.01 }, { gap = 0.012, side = "-", law = "restitution", e = 0.6 }]
[[system.dampers]]
name = "stop"
attached_to = ["floor2", "ground"]
law = "linear"
kc = 1e6
walls = [{ gap = 0.02 }, { gap = 0.03, side = "-", kc = 2e6 }]
[system.force]
at = { roof = 1500.0 }
f = 2.0
[set]
cell.k = 200.0
force.floor1 = 1.0
"""


@pytest.mark.parametrize("name", HOSTS)
def test_a_file_holds_exactly_the_system(name):
    host = HOSTS[name]
    dof = host.dofs[-1]
    cell = nv.Damper(
        "cell", dof, m=0.1, k=1 / 3, walls=[nv.Wall(-0.1, "-", e=0.1, law="restitution")]
    )
    system = nv.System.from_host(host, [cell], base={"acceleration": 0.1}, omega=math.pi, name="it")
    text = toml_text({"system": system.to_table()})
    for other in (
        any_system_from(tomllib.loads(text)["system"]),
        pickle.loads(pickle.dumps(system)),
    ):
        assert other.to_table() == system.to_table()
        for matrix in ("M", "K", "C", "shape", "inertia", "frequencies"):
            assert np.array_equal(getattr(other.host, matrix), getattr(host, matrix)), matrix
        for word in ("dofs", "coordinates", "condensed", "note", "is_plain"):
            assert getattr(other.host, word) == getattr(host, word), word
        assert np.array_equal(other.push(), system.push())
        assert np.array_equal(other.rows(), system.rows())
        assert (other.name, other.omega) == ("it", math.pi)


def test_a_file_names_a_host_its_dampers_and_its_force(tmp_path):
    (tmp_path / "frame.toml").write_text(FILE)
    system = nv.load_system(tmp_path / "frame.toml", **{"stop.gap": 0.05})
    frame = nv.shear_frame([1e4] * 3, [8e6] * 3, ratio=0.01)
    cell = nv.Damper(
        "cell", "roof", m=300, k=200.0,
        walls=[nv.Wall(0.01, K=3e7), nv.Wall(0.012, "-", "restitution", e=0.6)],
    )  # fmt: skip
    sides = zip("+-", (1e6, 2e6), strict=True)
    stop = nv.Damper(
        "stop", ("floor2", "ground"), walls=[nv.Wall(0.05, s, "linear", kc=kc) for s, kc in sides]
    )
    other = nv.System.from_host(
        frame, [cell, stop], force={"roof": 1500.0, "floor1": 1.0}, omega=4 * math.pi
    )
    assert system.parameters == other.parameters
    for key in ("host", "dampers", "force"):
        assert system.to_table()[key] == other.to_table()[key]
    assert system.heading() == "a frame with a cell and a stop"


def test_a_file_states_dampers_by_frequency_and_ratio_and_keeps_what_it_states():
    document = tomllib.loads(FILE)["system"]
    document["dampers"][0] |= {"f": 1.9, "zeta": 0.1}
    document["dampers"].append(
        {"name": "tmd", "attached_to": "roof", "m": 90.0, "frequency_ratio": 0.9, "c": 3.0}
    )
    system = any_system_from(document)
    cell, tmd, _ = system.dampers
    assert cell.statements == {"m": 300.0, "f": 1.9, "zeta": 0.1}
    frame = nv.shear_frame([1e4] * 3, [8e6] * 3)
    assert tmd.k == pytest.approx(90.0 * (0.9 * frame.frequencies[0]) ** 2, rel=1e-12)
    assert tmd.statements == {"m": 90.0, "frequency_ratio": 0.9, "c": 3.0}
    table = system.to_table()
    assert table["dampers"][0]["f"] == 1.9
    assert "k" not in table["dampers"][0]
    other = any_system_from(tomllib.loads(toml_text({"system": table}))["system"])
    assert other.to_table() == table
    assert other.parameters == system.parameters


def test_the_file_of_the_page_is_read():
    page = (REPO / "docs" / "hosts.md").read_text(encoding="utf-8")
    (text,) = re.findall(r"```toml\n(.*?)```", page, re.DOTALL)
    system = any_system_from(tomllib.loads(text)["system"])
    assert system.parameters["cell1.gap-"] == 0.012
    assert system.parameters["omega"] == 4 * math.pi


def test_hosts_of_files_matrices_modes_and_beams_are_those_of_python(tmp_path):
    np.savez(tmp_path / "a.npz", M=FRAME.M, K=FRAME.K, dofs=FRAME.dofs)
    path, modes = str(tmp_path / "a.npz"), [{"f": 4.1, "shape": {"tip": 2.0}}]
    strip = {"length": 1.0, "bending_stiffness": 65.6, "mass_per_length": 1.18, "elements": 4}
    for table, host in (
        ({"file": path, "ratio": 0.1}, nv.Host.from_file(path, ratio=0.1)),
        (
            {
                "M": LIGHT[0].tolist(),
                "K": LIGHT[1].tolist(),
                "dofs": [1, 2, 3, 4],
                "influence": [1, 1, 1, 0],
                "ratio": "1%",
                "condense": True,
            },
            NODES,
        ),
        ({"M": [2, 3], "K": [[5, -1], [-1, 5]]}, nv.Host(np.diag([2, 3]), [[5, -1], [-1, 5]])),
        ({"modes": modes}, nv.Host.from_modes(modes)),
        ({"beam": strip, "keep": 3}, nv.beam(1.0, 65.6, 1.18, elements=4).reduced(3)),
        ({"chain": {"masses": [1], "springs": [2]}}, nv.chain([1], [2])),
    ):
        assert table_of(host_from(table)) == table_of(host)
    # a reduction keeps the static response where dampers and forces are
    document = tomllib.loads(FILE)["system"]
    document["host"]["keep"] = 1
    note = any_system_from(document).host.note
    assert note == "1 of 3 modes and the static response of roof, floor2"


def test_forces_and_dampers_act_on_degrees_of_freedom_with_a_mass(error_of):
    """Those that were condensed follow the others, as if no force acted on them."""
    ball = nv.Damper("ball", "3", m=0.5)
    for host in (NODES, NODES.reduced(2, statics=["4"])):
        line = error_of(nv.System.from_host, host, [ball], force={"1": 1.0}, omega=1.0)
        assert "unknown attached_to '3'; allowed: 1, 2, 4" in line
        line = error_of(nv.System.from_host, host, [], force={"3": 1.0}, omega=1.0)
        assert "unknown degree of freedom of the force '3'; allowed: 1, 2, 4" in line
        assert "unknown key '3'" in error_of(host.frequency_response, 1.0, force={"3": 1.0})
    system = nv.System.from_host(NODES, [], force={"1": 1.0}, omega=1.0)
    assert system.scene.components[::2] == ("1", "2", "4")
    assert "force.3" not in system.allowed
    # it follows the others by the third row of K, whose forces add up to 0
    row, moved = system.displacement("3")
    assert row == pytest.approx(-LIGHT[1][2, [0, 1, 3]] / LIGHT[1][2, 2], rel=1e-14)
    assert moved == 1.0


def test_the_ground_moves_some_degrees_of_freedom():
    host = nv.chain([2.0, 3.0], [5.0, 5.0, 5.0])
    ball = nv.Damper("ball", "x2", m=0.5)
    base = {"influence": {"x2": 0.5}, "acceleration": 4.0}
    system = nv.System.from_host(host, [ball], base=base, omega=1.0)
    assert system.push().tolist() == [0.0, -6.0, -1.0]
    assert host.inertia.tolist() == [2.0, 3.0]
    assert any_system_from(system.to_table()).push().tolist() == [0.0, -6.0, -1.0]
    with pytest.raises(nv.RequestError, match="influence: the coordinates are modes"):
        nv.System.from_host(host.reduced(1), base=base, omega=1.0)


WRONG = [
    ('kind = "host"', 'kind = "hots"', r"\[system\]: unknown kind 'hots'; did you mean 'host'"),
    ("ratio = 0.01", "ratio = -1", r"shear_frame: ratio = \[-1\] must be finite numbers >= 0"),
    ("ratio = 0.01", "ratoi = 1", r"unknown key 'ratoi'; did you mean 'ratio'"),
    ("ratio = 0.01", "C = [1]", "shear_frame: C has the shape .1, 1., but M has .3, 3."),
    ("ratio = 0.01", 'file = "a.npz"', "file beside shear_frame: give one of file, M, modes"),
    ("ratio = 0.01", 'statics = ["roof"]', "statics without a reduction"),
    ("stiffnesses = ", "springs = ", r"shear_frame: unknown key 'springs'; allowed: masses, sti"),
    (", stiffnesses = [8e6, 8e6, 8e6]", "", "shear_frame: stiffnesses is missing"),
    ("masses = [1e4, 1e4, 1e4]", "masses = 3", "shear_frame: masses = 3 must be finite numbers"),
    ("shear_frame = {", "# {", r"\[system.host\]: no host: give one of file, M, modes"),
    ('name = "cell"', 'nam = "cell"', r"\[\[system.dampers\]\] 1: unknown key 'nam'"),
    ('name = "cell"', "", r"\[\[system.dampers\]\] 1: name is missing"),
    ('name = "stop"', 'name = "cell"', "damper 'cell': the name is taken"),
    (
        'attached_to = "roof"',
        "attached_to = 3.5",
        "attached_to: 3.5 must be a text or a whole number",
    ),
    ("gap = 0.02", "gape = 0.02", r"\[\[system.dampers\]\] 2: wall 1: unknown key 'gape'"),
    ("gap = 0.02", "", r"\[\[system.dampers\]\] 2: wall 1: gap is missing"),
    ("kc = 1e6", "K = 1e6", "wall 1: unknown constant of law 'linear' 'K'"),
    ("e = 0.6", "e = 6", r"\[\[system.dampers\]\] 1: wall 2: e = 6.0 is not allowed"),
    ("f = 2.0", "", r"\[system.force\]: one of omega and f must be given"),
    ("f = 2.0", "phase = 2.0", r"\[system.force\]: unknown key 'phase'"),
    ("f = 2.0", "f = 2.0\nbase = { acceleration = 1.0 }", "needs one of force and base"),
    (
        "at = { roof = 1500.0 }",
        "base = { acceleration = 1.0, displacement = 0.1 }",
        "base needs one of acceleration and displacement",
    ),
    ("at = { roof", "at = { top", "of the force 'top'; allowed: floor1, floor2, roof"),
    ("cell.k = 200.0", "cell.kk = 2", r"\[set\]: damper 'cell': unknown parameter 'kk'"),
    ("[system.force]", "[system.load]", r"\[system\]: unknown key 'load'"),
]


@pytest.mark.parametrize(("old", "new", "message"), WRONG)
def test_a_wrong_file_is_refused_in_one_line_with_the_place(tmp_path, old, new, message, error_of):
    assert FILE.count(old) == 1
    path = tmp_path / "frame.toml"
    path.write_text(FILE.replace(old, new))
    line = error_of(nv.load_system, path)
    assert line.startswith(f"{path}: ")
    assert re.search(message, line)


MODES = {
    "kind": "host", "force": {"base": {"influence": "all", "acceleration": 1.0}, "omega": 2.0},
    "host": {"K": [4.0, 5.0], "ratio": [0.1], "shape": [[1.0, 0.5], [2.0, 1.0]], "note": "n",
             "inertia": [1.0, 1.0], "dofs": ["a", "b"], "influence": [1.0, 0.0]},
}  # fmt: skip


def places_in(table, path=()):
    """Yield the places of all values in nested tables and lists."""
    for key, value in table.items() if isinstance(table, dict) else enumerate(table):
        yield (*path, key)
        if isinstance(value, dict | list):
            yield from places_in(value, (*path, key))


@pytest.mark.parametrize("table", [tomllib.loads(FILE)["system"], MODES])
def test_no_value_in_a_file_raises_anything_but_one_line(table):
    messages = []
    for *path, last in [*places_in(table)]:
        for value in (-1, "x", [], {}, True, math.nan, [[1]], ["a", []], {"a": 1}, 10**400):
            changed = copy.deepcopy(table)
            functools.reduce(lambda part, key: part[key], path, changed)[last] = value
            try:
                any_system_from(any_system_from(changed).to_table())
            except nv.RequestError as error:
                messages.append(str(error))
    assert len(messages) > 200
    assert "\n" not in "".join(messages)


def test_tasks_for_one_damper_refuse_hosts_in_one_line(tmp_path, error_of):
    path = tmp_path / "frame.toml"
    path.write_text(FILE)
    for source in (str(path), nv.load_system(path)):
        line = error_of(nv.slow_manifold, source)
        assert "one mass on a nonlinear spring" in line


def test_the_two_ends_of_a_damper_are_a_tuple_as_in_python(tmp_path):
    path = tmp_path / "frame.toml"
    path.write_text(FILE)
    assert nv.load_system(path).dampers[1].attached_to == ("floor2", "ground")


@pytest.mark.kernels
def test_orbits_take_files_and_changed_numbers(tmp_path):
    path = tmp_path / "frame.toml"
    path.write_text(FILE)
    changes = {"cell.gap": 0.002, "force.roof": 3e3}
    orbit = nv.simulate(path, 4, quiet=True, **changes)
    same = nv.simulate(any_system_from(orbit.system.to_table()), 4, quiet=True)
    assert len(same.impacts) > 2
    assert np.array_equal(orbit.section, same.section)
    assert orbit.system.parameters == nv.load_system(path).with_(**changes).parameters
