"""Nonlinear springs of dampers: numbers by name, files, pickles, refusals in one line."""

import pickle
import re

import numpy as np
import pytest

import nlds_vines as nv
from nlds_vines.archives.files import parse_toml
from nlds_vines.model.catalog import any_system_from
from nlds_vines.model.dampers import has_lower_bound
from nlds_vines.model.parameters import DESCRIBED

HOST = nv.chain([1.0], [1.0])


def sink(**options):
    return nv.Damper("nes", "x1", **{"m": 0.05, "c": 0.01, **options})


def system_of(*dampers):
    return nv.System.from_host(HOST, dampers, force={"x1": 0.02}, omega=1.0)


CUBIC = system_of(sink(spring=nv.Spring(k3=0.07)))
BISTABLE = system_of(sink(k=-0.02, spring=nv.Spring(k2=0.01, k3=0.2, k5=0.3)))
MIXED = system_of(
    sink(spring=nv.Spring(k3=0.07), walls=[nv.Wall(0.4, side, law="power", K=9.0, exponent=2.0)
                                           for side in "+-"])
)  # fmt: skip


def test_coefficients_that_are_given_are_parameters():
    assert dict(CUBIC.parameters) == {
        "nes.m": 0.05, "nes.k": 0.0, "nes.c": 0.01, "nes.k3": 0.07,
        "x1.m": 1.0, "x1.k": 1.0, "force.x1": 0.02, "omega": 1.0,
    }  # fmt: skip
    assert [name for name in CUBIC.allowed if name.startswith("nes.k")] == ["nes.k", "nes.k3"]
    assert {"nes.k2", "nes.k3", "nes.k5"} <= {*BISTABLE.parameters}
    assert system_of(sink(spring=nv.Spring(k5=0))).parameters["nes.k5"] == 0.0
    assert CUBIC.scene.springs == ("nes",)
    assert not CUBIC.scene.is_linear
    assert system_of(sink(k=0.1)).scene.is_linear
    assert not nv.load_system("ssul-set6").scene.is_linear
    assert nv.load_system("tmd").scene.is_linear
    assert "k = 0, k3 = 0.07, c = 0.01" in dict(CUBIC.outline())["nes"]
    entry = DESCRIBED["nes.k3"]
    assert (entry.symbol, entry.unit) == ("k₃ of nes", "N/m^3")
    assert entry.meaning == "cubic stiffness of the spring of nes"


def test_coefficients_are_replaced_by_name():
    stiffer = CUBIC.with_(**{"nes.k3": 0.1})
    assert stiffer.dampers[0].spring == nv.Spring(k3=0.1)
    assert stiffer.changes_from(CUBIC) == {"nes.k3": 0.1}
    assert stiffer.sources == {"nes.k3": "set by the user"}
    assert stiffer.has_parts_of(CUBIC)
    assert not BISTABLE.has_parts_of(CUBIC)
    both = MIXED.with_(nes={"k3": 0.1, "gap+": 0.3, "m": 0.1})
    assert both.parameters.items() >= {"nes.k3": 0.1, "nes.gap+": 0.3, "nes.m": 0.1}.items()
    assert both.dampers[0].walls[1].gap == 0.4
    cells = CUBIC.cells({"nes.k3": np.array([0.1, 0.2]), "nes.k": np.array([-1.0, 0.0])})
    assert cells.dtype.names == ("omega", "nes.k3", "nes.k")


@pytest.mark.parametrize("system", [CUBIC, BISTABLE, MIXED], ids=["cubic", "bistable", "mixed"])
def test_files_and_pickles_keep_springs(system):
    table = system.to_table()
    assert any_system_from(table).to_table() == table
    copy = pickle.loads(pickle.dumps(system))
    assert copy.dampers[0].spring == system.dampers[0].spring
    assert copy.to_table() == table
    assert pickle.loads(pickle.dumps(system.dampers[0].spring)) == system.dampers[0].spring


def test_a_file_states_a_spring(tmp_path):
    text = """
        [system]
        kind = "host"
        host = { chain = { masses = [1.0], springs = [1.0] } }
        force = { at = { x1 = 0.02 }, omega = 1.0 }
        [[system.dampers]]
        name = "nes"
        attached_to = "x1"
        m = 0.05
        k = -0.02
        spring = { k3 = 0.07, k5 = 1 }
        [set]
        nes.k3 = 0.08
    """
    path = tmp_path / "nes.toml"
    path.write_text(text)
    damper = nv.load_system(path).dampers[0]
    assert (damper.k, damper.spring) == (-0.02, nv.Spring(k3=0.08, k5=1.0))
    assert parse_toml(text, "")["system"]["dampers"][0]["spring"] == {"k3": 0.07, "k5": 1}


def test_force_slope_and_energy_belong_together():
    spring, r = nv.Spring(k2=0.3, k3=-2.0, k5=7.0), np.linspace(-1.5, 1.5, 7)
    assert spring.force(r) == pytest.approx(0.3 * r**2 - 2.0 * r**3 + 7.0 * r**5, rel=1e-14)
    step = 1e-4
    slope = (spring.force(r + step) - spring.force(r - step)) / (2 * step)
    force = (spring.energy(r + step) - spring.energy(r - step)) / (2 * step)
    assert spring.slope(r) == pytest.approx(slope, abs=1e-5)
    assert spring.force(r) == pytest.approx(force, abs=1e-5)


def test_an_energy_has_a_lower_bound_or_falls_without_end():
    """The energy at |r| = 1e8, where the highest power alone counts, decides."""
    choices = np.array([-1.0, 0.0, 1.0])
    grids = np.meshgrid(choices, choices, choices, choices, indexing="ij")
    k, k2, k3, k5 = (grid.ravel() for grid in grids)
    energies = []
    for r in (-1e8, 1e8):
        energies.append(k * r**2 / 2 + k2 * r**3 / 3 + k3 * r**4 / 4 + k5 * r**6 / 6)
    assert has_lower_bound(k, k2, k3, k5).tolist() == (np.min(energies, axis=0) >= 0.0).tolist()


UNBOUNDED = "the energy of the spring of nes, .* must have a lower bound"


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: nv.Spring(), "a spring needs a coefficient: k2, k3, k5"),
        (lambda: nv.Spring(k3="1e5"), "k3 = '1e5' must be a number"),
        (lambda: nv.Spring(k3=np.inf), "k3 = inf must be a finite number"),
        (lambda: nv.Spring(k4=1.0), r"k4 is no coefficient .* allowed: k2, k3, k5"),
        (lambda: nv.Spring(k3=1.0, exponent=2.5), r"\|r\|\^n .* two walls with gap 0 under law"),
        (lambda: sink(spring={"k3": 1.0}), "spring = {'k3': 1.0} must be a Spring"),
        (lambda: sink(k=-1.0), "nes.k = -1.0 is not allowed: .* must be >= 0"),
        (lambda: sink(spring=nv.Spring(k3=-1.0)), UNBOUNDED),
        (lambda: sink(spring=nv.Spring(k2=1.0)), UNBOUNDED),
        (lambda: sink(k=-1.0, spring=nv.Spring(k3=0.0)), "k = -1, k2 = 0, k3 = 0, k5 = 0 are not"),
        (lambda: sink(k=-1.0, c=0.0, zeta=0.1, spring=nv.Spring(k3=1.0)), "zeta means nothing"),
        (lambda: CUBIC.with_(**{"nes.k3": -0.1}), f"damper 'nes': .*{UNBOUNDED}"),
        (lambda: CUBIC.with_(**{"nes.k5": 0.1}), "damper 'nes': unknown parameter 'k5'"),
        (lambda: CUBIC.cells({"nes.k3": np.array([0.1, -0.1])}), f"k3 = -0.1, .*{UNBOUNDED}"),
        (lambda: CUBIC.cells({"nes.k3": np.zeros(2), "nes.k": np.array([0.1, -0.1])}), UNBOUNDED),
        (lambda: system_of(sink()).cells({"nes.k": np.array([1.0, -0.1])}),
         "nes.k = -0.1 is not allowed: .* must be >= 0"),
    ],
)  # fmt: skip
def test_wrong_springs_are_refused_in_one_line(call, message, error_of):
    assert re.search(message, error_of(call))


def test_a_wrong_key_of_a_spring_is_refused(error_of):
    table = CUBIC.to_table()
    table["dampers"][0]["spring"] = {"k3": 1.0, "k4": 1.0}
    assert "spring: k4 is no coefficient" in error_of(any_system_from, table)
    table["dampers"][0]["spring"] = 1.0
    assert "spring: a spring = 1.0" in error_of(any_system_from, table)


@pytest.mark.parametrize("name", ["nes-cubic", "nes-bistable", "nes-vibro-impact-cubic"])
def test_named_sinks_are_on_one_structure_and_every_value_has_a_source(name):
    system = nv.load_system(name)
    assert system.sources.keys() == system.parameters.keys()
    assert all(system.sources.values())
    assert system.name == name
    shared = ("x1.m", "x1.k", "nes.m", "nes.c", "nes.k3", "force.x1", "omega")
    cubic = nv.load_system("nes-cubic").parameters
    assert [system.parameters[key] for key in shared] == [cubic[key] for key in shared]
    assert nv.load_system(name, **{"nes.k3": 0.5}).sources["nes.k3"] == "set by the user"


def test_the_named_sinks_have_the_numbers_of_their_sources():
    blow = nv.slow_manifold(nv.load_system("nes-cubic"))
    k3 = nv.load_system("nes-cubic").parameters["nes.k3"]
    assert k3 == pytest.approx(1.1 * blow.threshold_k3(0.1), abs=5e-6)
    first, last = blow.folds
    assert first.force < blow.force < last.force
    bistable = nv.load_system("nes-bistable")
    p = bistable.parameters
    assert np.sqrt(-2.0 * p["nes.k"] / p["nes.m"]) == pytest.approx(1.0, rel=1e-15)
    well = bistable.rests[-1].strokes["nes"]
    in_well = p["nes.k"] + bistable.dampers[0].spring.slope(well)
    assert in_well / p["nes.m"] == pytest.approx(1.0, rel=1e-14)
