"""Systems of hosts: names of their numbers, replacements, refusals in one line."""

import re

import numpy as np
import pytest

import nlds_vines as nv
from nlds_vines.errors import RequestError
from nlds_vines.loads.request import is_of_load
from nlds_vines.model.parameters import DESCRIBED

FRAME = nv.shear_frame([1e4] * 3, [8e6] * 3, ratio=0.02)
BODIES = {"E1": 2e11, "E2": 7e10, "nu1": 0.3, "nu2": 0.33, "A": 2.0, "B": 2.0, "q1": 0.318}
CELL = nv.Damper(
    "cell", "roof", m=900.0, k=50.0,
    walls=[nv.Wall(0.05, K=1e8), nv.Wall(0.06, "-", law="restitution", e=0.5)],
)  # fmt: skip
BALL = nv.Damper("ball", "floor2", m=300.0, c=2.0, walls=[nv.Wall(0.02, **BODIES)])
STOP = nv.Damper("stop", ("roof", "floor1"), walls=[nv.Wall(0.01, s, K=1e7) for s in "+-"])
SYSTEM = nv.System.from_host(FRAME, [CELL, STOP, BALL], force={"roof": 700.0}, omega=12.6)


def test_numbers_have_names_and_those_of_equal_walls_one_name():
    assert dict(SYSTEM.parameters) == {
        "cell.m": 900.0, "cell.k": 50.0, "cell.c": 0.0, "cell.gap+": 0.05, "cell.gap-": 0.06,
        "cell.K+": 1e8, "cell.e-": 0.5,
        "ball.m": 300.0, "ball.k": 0.0, "ball.c": 2.0, "ball.gap": 0.02,
        **{f"ball.{name}": value for name, value in BODIES.items()},
        "stop.k": 0.0, "stop.c": 0.0, "stop.gap": 0.01, "stop.K": 1e7,
        **{f"{floor}.m": 1e4 for floor in FRAME.dofs},
        **{f"{floor}.k": 8e6 for floor in FRAME.dofs},
        "host.ratio": 0.02, "force.roof": 700.0, "omega": 12.6,
    }  # fmt: skip
    assert all(name in DESCRIBED for name in SYSTEM.allowed)
    assert not SYSTEM.parameters.keys() - {*SYSTEM.allowed}
    entry = DESCRIBED["cell.gap+"]
    assert (entry.unit, entry.symbol) == ("m", "gap+ of cell")
    assert entry.meaning == "gap at rest of cell, wall +"
    assert DESCRIBED["force.roof"].meaning == "amplitude of the force on roof"
    assert "cell.speed" not in DESCRIBED
    assert "cell" not in DESCRIBED


REPLACED = [
    ({"cell.k": 300.0}, {"cell.k": 300.0}),
    ({"cell": {"k": 300.0, "gap+": 0.01}}, {"cell.k": 300.0, "cell.gap+": 0.01}),
    ({"cell.gap": 0.03}, {"cell.gap+": None, "cell.gap-": None, "cell.gap": 0.03}),
    ({"stop.gap-": 0.03}, {"stop.gap": None, "stop.gap+": 0.01, "stop.gap-": 0.03}),
    ({"cell.e": 0.7, "cell.K": 3e8}, {"cell.e-": 0.7, "cell.K+": 3e8}),
    ({"ball.K": 3e8}, {**{f"ball.{name}": None for name in BODIES}, "ball.K": 3e8}),
    ({"ball.E1": 3e9}, {"ball.E1": 3e9}),
    ({"ball.hunt_crossley": 0.2}, {"ball.hunt_crossley": 0.2}),
    ({"force.floor1": 5.0}, {"force.floor1": 5.0}),
    ({"ground.acceleration": 0.5}, {"force.roof": None, "ground.acceleration": 0.5}),
    ({"ground.displacement": 0.1}, {"force.roof": None, "ground.displacement": 0.1}),
    ({"f": 2.0}, {"omega": 4 * np.pi}),
]  # fmt: skip


@pytest.mark.parametrize(("changes", "after"), REPLACED)
def test_numbers_are_replaced_by_name(changes, after):
    system = SYSTEM.with_(**changes)
    expected = {**SYSTEM.parameters, **after}
    assert dict(system.parameters) == {k: v for k, v in expected.items() if v is not None}
    assert system.host is FRAME
    names, values = [*changes], [*changes.values()]
    if "cell" not in changes:
        assert SYSTEM.with_values(names, values).parameters == system.parameters
    # what varies is no attribute
    attributes = SYSTEM.attributes([name for name in names if name != "cell"])
    assert attributes.keys().isdisjoint({*changes} & {*SYSTEM.parameters})
    assert "cell.gap" not in changes or "cell.gap+" not in attributes
    back = {name: SYSTEM.parameters[name] for name, value in after.items() if value is None}
    if not back.keys() & {"stop.gap", "ball.E1"}:
        assert system.with_(**back).parameters.items() >= back.items()


def test_a_damper_may_be_stated_by_its_frequency_and_its_damping_ratio():
    """k = (2 pi f)^2 m and c = 2 zeta sqrt(k m); f and zeta stay if the mass changes."""
    m, f, zeta = 300.0, 1.9, 0.12
    tuned = nv.Damper("tuned", "roof", m=m, f=f, zeta=zeta)
    k = (2 * np.pi * f) ** 2 * m
    assert (tuned.k, tuned.c) == pytest.approx((k, 2 * zeta * np.sqrt(k * m)), rel=1e-14)
    system = nv.System.from_host(FRAME, [tuned], force={"roof": 1.0}, f=2.0)
    assert system.omega == 4 * np.pi
    heavy = system.with_(**{"tuned.m": 2 * m}).parameters
    assert (heavy["tuned.k"], heavy["tuned.c"]) == pytest.approx((2 * k, 2 * tuned.c), rel=1e-14)
    fast = system.with_(**{"tuned.f": 2 * f}).parameters
    assert (fast["tuned.k"], fast["tuned.c"]) == pytest.approx((4 * k, 2 * tuned.c), rel=1e-14)
    stiff = system.with_(**{"tuned.k": 4 * k})
    assert stiff.parameters["tuned.c"] == pytest.approx(2 * tuned.c, rel=1e-14)
    assert stiff.dampers[0].statements == {"m": m, "k": 4 * k, "zeta": zeta}
    plain = system.with_(**{"tuned.c": 5.0, "tuned.k": 6.0}).with_(**{"tuned.m": 7.0})
    assert plain.dampers[0].own == {"m": 7.0, "k": 6.0, "c": 5.0}
    assert system.following(["tuned.m"]) == {"tuned.m", "tuned.k", "tuned.c"}
    assert system.following(["tuned.f"]) == {"tuned.k", "tuned.c"}
    assert system.following(["tuned.zeta"]) == {"tuned.c"}


def test_the_frequency_ratio_of_a_damper_counts_from_the_lowest_mode_of_the_host():
    exact = 2 * np.sqrt(800) * np.sin(np.pi / 14)  # of three equal storeys
    tuned = nv.Damper("tuned", "roof", m=300.0, frequency_ratio=0.97, zeta=0.1)
    free = nv.chain([1.0, 1.0], [0.0, 8.0])  # whose first mode has no frequency
    for host, omega in ((FRAME, exact), (free, 4.0)):
        damper = nv.Damper("tuned", host.dofs[-1], m=300.0, frequency_ratio=0.97, zeta=0.1)
        system = nv.System.from_host(host, [damper], force={host.dofs[0]: 1.0}, f=2.0)
        (placed,) = system.dampers
        assert placed.k == pytest.approx((0.97 * omega) ** 2 * 300.0, rel=1e-12)
        assert placed.c == pytest.approx(0.2 * 0.97 * omega * 300.0, rel=1e-12)
    assert np.isnan([tuned.k, tuned.c]).all()  # before it is on a host


def test_the_frequency_ratio_of_a_damper_varies_as_its_frequency_does(error_of):
    tuned = nv.Damper("tuned", "roof", m=300.0, frequency_ratio=0.97, zeta="10%")
    system = nv.System.from_host(FRAME, [tuned], force={"roof": 1.0}, f=2.0)
    assert system.dampers[0].zeta == 0.1
    other = nv.Damper("tuned", "roof", m=300.0, frequency_ratio=0.9, zeta=0.1)
    expected = nv.System.from_host(FRAME, [other], force={"roof": 1.0}, f=2.0)
    name = "tuned.frequency_ratio"
    assert name in system.allowed
    assert system.with_(**{name: 0.9}).to_table()["dampers"] == expected.to_table()["dampers"]
    assert system.with_values([name], [0.9]).to_table() == expected.to_table()
    assert system.following([name]) == {"tuned.k", "tuned.c"}
    lighter = system.with_(**{name: 0.9, "tuned.m": 200.0}).dampers[0]
    assert lighter.k == pytest.approx(expected.dampers[0].k * 200.0 / 300.0, rel=1e-14)
    stiffer = system.with_(**{"host.K": 1.21}).dampers[0]
    assert stiffer.frequency_ratio == 0.97
    assert stiffer.k == pytest.approx(1.21 * system.dampers[0].k, rel=1e-13)
    assert stiffer.c == pytest.approx(1.1 * system.dampers[0].c, rel=1e-13)
    assert system.following(["host.K"]) == {"tuned.k", "tuned.c"}
    assert system.following(["host.C"]) == set()
    free = nv.System.from_host(
        nv.chain([1.0], [0.0]), [nv.Damper("tuned", "x1", m=1.0, k=1.0)], force={"x1": 1.0}, f=2.0
    )
    assert error_of(free.with_, **{name: 0.9}).startswith(
        "damper 'tuned': frequency_ratio: no mode of the host"
    )


def test_a_damper_may_have_the_name_of_a_load():
    assert is_of_load("tone.omega")
    assert not is_of_load("tone.k")


def test_the_stiffness_of_bodies_follows_from_their_constants():
    softer = SYSTEM.with_(**{"ball.E1": 2e10})
    wall = nv.Wall(0.02, **{**BODIES, "E1": 2e10})
    assert softer.dampers[1].walls[0].constants["K"] == wall.constants["K"]


def test_a_damper_moves_to_another_place():
    moved = SYSTEM.with_(**{"cell.attached_to": "floor1", "stop.attached_to": ("roof", "ground")})
    assert moved.rows()[0].tolist() == [1, 0, 0, -1, 0]
    assert moved.rows()[2].tolist() == [0, 0, 1, 0, 0]
    assert moved.attributes()["cell.attached_to"] == "floor1"


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"cel.k": 1.0}, "unknown parameter 'cel.k'; did you mean 'cell.k'"),
        ({"cell": 1.0}, "unknown parameter 'cell'"),
        ({"m2": 1.0}, "unknown parameter 'm2'"),
        (
            {"cell.kk": 1.0},
            "damper 'cell': unknown parameter 'kk'; allowed: m, k, c, f, zeta, fr",
        ),
        ({"stop.m": 1.0}, "damper 'stop': unknown parameter 'm'; allowed: k, c, gap"),
        ({"cell.e+": 1.0}, "damper 'cell': unknown parameter 'e[+]'"),
        ({"ball.gap-": 1.0}, "damper 'ball': unknown parameter 'gap-'"),
        ({"force.top": 1.0}, "unknown degree of freedom 'top'"),
        ({"cell.m": 0.0}, r"cell.m = 0.0 is not allowed: cell.m \(mass of cell\) \[kg\] must be >"),
        ({"cell.K": "stiff"}, "cell.K = 'stiff' must be a number"),
        ({"f": -1.0}, "f = -1.0 is not allowed"),
        ({"cell.gap": 0.1, "cell.gap+": 0.2}, "cell.gap beside cell.gap[+]: give one of them"),
        ({"f": 1.0, "omega": 6.0}, "f beside omega: give one of them"),
        (
            {"ground.acceleration": 1.0, "force.roof": 6.0},
            "ground.acceleration beside force.roof: give one of them",
        ),
        (
            {"ground.acceleration": 1.0, "ground.displacement": 0.1},
            "ground.acceleration beside ground.displacement: give one of them",
        ),
        ({"ground": 1.0}, "unknown parameter 'ground'"),
        ({"ground.velocity": 1.0}, "ground: unknown motion 'velocity'"),
        ({"stop.gap+": -0.02}, "damper 'stop': its walls overlap by 0.01 m"),
        ({"ball.K": 1.0, "ball.E1": 1.0}, "damper 'ball': K stands beside constants"),
        ({"cell.E1": 1.0}, "damper 'cell': law 'hertz' needs E2"),
        ({"cell.attached_to": "top"}, "damper 'cell': unknown attached_to 'top'"),
        ({"cell.attached_to": ("roof", "ground")}, "damper 'cell': has no mass m between two"),
    ],
)
def test_wrong_replacements_are_refused_in_one_line(changes, message, error_of):
    assert re.search(message, error_of(SYSTEM.with_, **changes))


@pytest.mark.parametrize("name", ["a.b", "a/b", "a=b", "a$", " a", "", "force", "ground", "host"])
def test_names_of_dampers_stand_in_others(name, error_of):
    assert error_of(nv.Damper, name, "roof", m=1.0).startswith("name = ")


HARD = nv.Wall(0.1, K=1.0)


def hung(name="a", place="roof", **options):
    return nv.Damper(name, place, **{"m": 1.0, **options})


def of(*dampers, host=FRAME, **load):
    return nv.System.from_host(host, dampers, **{"force": {"roof": 1.0}, "omega": 1.0, **load})


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: nv.Wall(0.1, "left"), "unknown side 'left'"),
        (lambda: nv.Wall(0.1, law="hertzian"), "did you mean 'hertz'"),
        (lambda: nv.Wall(0.1), "law 'hertz' needs E1, .*, or K"),
        (lambda: nv.Wall(0.1, K=-1.0), "K = -1.0 is not allowed"),
        (lambda: nv.Wall(0.1, law="restitution", e=0.5, K=1.0), "constant of law 'restitution'"),
        (lambda: nv.Wall(0.1, K=1.0, E1=1.0), "K stands beside constants"),
        (lambda: hung(m=None), "damper 'a': a mass m is missing"),
        (lambda: hung(place=("roof", "ground")), "damper 'a': has no mass m between"),
        (lambda: hung(place=("roof", "roof")), "must be a degree of freedom, or two different"),
        (lambda: hung(m=0.0), "a.m = 0.0 is not allowed: .* must be > 0"),
        (lambda: hung(k=1.0, f=1.0), "damper 'a': k beside f: give one of them"),
        (lambda: hung(f=1.0, frequency_ratio=1.0), "f beside frequency_ratio: give one of them"),
        (lambda: hung(k=1.0, c=1.0, zeta=0.1), "damper 'a': c beside zeta: give one of them"),
        (lambda: hung(zeta=0.1), "damper 'a': zeta means nothing with k = 0.0"),
        (lambda: hung(f=-1.0), r"a.f = -1.0 is not allowed: .* \[Hz\] must be >= 0"),
        (lambda: hung(m=None, place=("roof", "floor1"), f=1.0), "f needs a mass m, which is"),
        (lambda: SYSTEM.with_(**{"cell.f": 1.0, "cell.k": 1.0}), "cell.f beside cell.k: give one"),
        (lambda: SYSTEM.with_(**{"stop.frequency_ratio": 1.0}), "unknown parameter 'frequency_r"),
        (lambda: SYSTEM.with_(**{"cell.frequency_ratio": 1.0, "cell.k": 1.0}),
         "cell.frequency_ratio beside cell.k: give one of them"),
        (lambda: hung(f=1.0, zeta=5), "zeta = 5 is 500 % of critical .* is 0.05 or '5%'"),
        (lambda: hung(f=1.0, zeta="5"), "damper 'a': zeta = '5' must be a number, or as '2%'"),
        (lambda: of(force={"roof": 1.0, 5: 1.0, "5": 2.0}), "force = .* names a degree of freedom"),
        (lambda: of(f=1.0), "f beside omega: give one of them"),
        (lambda: of(f=-1.0, omega=None), "omega = -6.28.* must be > 0"),
        (lambda: of(f="2 Hz", omega=None), "f = '2 Hz' must be a number"),
        (lambda: of(hung(frequency_ratio=1.0), host=nv.chain([1.0], [0.0]), force={"x1": 1.0}),
         "damper 'a': frequency_ratio: no mode of the host has a frequency: give f or k"),
        (lambda: hung(k=-1.0), "a.k = -1.0 is not allowed: .* must be >= 0"),
        (lambda: hung(walls=HARD), "walls = .* must be a list of Wall"),
        (lambda: hung(walls=[HARD, HARD]), "two walls are on one side"),
        (lambda: hung(walls=[HARD, nv.Wall(-0.2, "-", K=1.0)]), "its walls overlap by 0.1 m"),
        (lambda: nv.System.from_host(FRAME, CELL), "dampers = .* must be a list of Damper"),
        (lambda: of(CELL, CELL), "'cell': the name is taken"),
        (lambda: of(hung("v_roof")), "'v_roof' names two components of states"),
        (lambda: of(hung("mode1"), host=FRAME.reduced(2)), "'mode1' names two components"),
        (lambda: of(hung(place="rooof")), "damper 'a': .*did you mean 'roof'"),
        (lambda: of(CELL, force=None), "one of force and base"),
        (lambda: of(CELL, force={"rof": 1.0}), "unknown degree of freedom of the force 'rof'"),
        (lambda: of(CELL, omega=0.0), "must be > 0"),
        (lambda: of(CELL, host=nv.Host.from_modes([{"f": 1.0, "shape": {"tip": 1, "roof": 0}}]),
                    force={"tip": 1.0}), "no mode of the host moves 'roof'"),
    ],
)  # fmt: skip
def test_wrong_systems_are_refused_in_one_line(call, message, error_of):
    assert re.search(message, error_of(call))


def test_numbers_of_numpy_are_stiffnesses_and_damping():
    damper = nv.Damper("cell", "x", m=np.float64(2.0), k=np.float64(8.0), c=np.float64(0.4))
    assert (damper.k, damper.c) == (8.0, 0.4)
    with pytest.raises(RequestError, match="k beside f: give one of them"):
        nv.Damper("cell", "x", m=2.0, k=np.float64(8.0), f=1.0)
