"""Scans: reading, overriding, canonical form, cells and start states."""

import dataclasses
import time
import tomllib
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import nlds_vines as nv
from nlds_vines import RequestError, Scan, load_scan
from nlds_vines.bifurcation.blocks import blocks_of
from nlds_vines.bifurcation.picture.choices import check_show, is_map, quantities
from nlds_vines.engine import records
from nlds_vines.engine.solver_settings import METHODS
from nlds_vines.engine.starts import Start, random_states, start_states
from nlds_vines.model.axis import Axis
from nlds_vines.model.catalog import catalog, load_system
from nlds_vines.model.presets import CELL
from nlds_vines.model.scenes import SCENES
from nlds_vines.model.system import System
from scans import scan_of

REPO = Path(__file__).resolve().parents[2]
MINIMAL = {"system": "ssul-set6", "vary": {"omega": {"values": [5.0, 6.0]}}}


def test_embedded_default_is_figure_8():
    default = load_scan()
    assert default.title == "Bifurcation diagram, SSul NES Set 6 (Figure 8)"
    assert default.system == load_system("ssul-set6")
    assert default.axes == (Axis("omega", np.linspace(5, 8, 1201)),)
    assert default.start == Start("rest")
    assert (default.transient, default.periods, default.method) == (600, 120, "exact")
    assert default.want == ("section", "impacts", "energy", "regime")
    assert (default.shape, default.starts, default.lanes) == ((1201,), 1, 1201)


def test_what_is_not_said_is_usual_and_what_is_said_counts_in_its_order():
    scan = load_scan(MINIMAL)
    assert (scan.transient, scan.periods, scan.method) == (600, 120, "exact")
    assert scan.start == Start()
    assert scan.title == "SSul NES, Set 6: ω"
    assert scan.want == ("section", "impacts", "energy", "regime")
    tmd = load_scan({**MINIMAL, "system": "tmd"})
    assert tmd.want == ("section", "energy", "regime")
    # [set] overrides the system
    scan = load_scan({**MINIMAL, "set": {"P": 600, "K": 2.5e7}})
    assert scan.system == load_system("ssul-set6", P=600, K=2.5e7)
    # axes come in the order of the file
    vary = {"k1": {"start": 3e4, "stop": 4e4, "num": 3}, "C": {"values": [0.1, 0.2]}}
    scan = load_scan({**MINIMAL, "vary": vary})
    assert scan.axes == (Axis("k1", [3e4, 3.5e4, 4e4]), Axis("C", [0.1, 0.2]))
    cells = scan.cells()
    assert (cells.shape, cells.dtype) == (scan.shape, CELL) == ((3, 2), CELL)
    assert cells["k1"].tolist() == [[3e4, 3e4], [3.5e4, 3.5e4], [4e4, 4e4]]
    assert cells["near"].tolist() == [[0.1, 0.2]] * 3
    assert np.all(cells["P"] == 800)
    # wants are kept in one order
    one, other = (
        load_scan({**MINIMAL, "record": {"want": want}})
        for want in (["regime", "section"], ["section", "regime"])
    )
    assert (one.want, one.hash) == (("section", "regime"), other.hash)


def test_axes_are_compared_by_name_and_values_and_read_only():
    values = np.array([1.0, 2.0])
    axis = Axis("P", values)
    values[0] = 5.0
    assert axis.values[0] == 1.0
    with pytest.raises(ValueError, match="read-only"):
        axis.values[0] = 1.0
    assert Axis("P", [1, 2]) == Axis("P", [1.0, 2.0])
    assert Axis("P", [1, 2]) != Axis("C", [1, 2])
    assert Axis("P", [1, 2]) != Axis("P", [1, 3])
    assert len({Axis("P", [-0.0]), Axis("P", [0.0])}) == 1
    assert Axis.spaced("P", 3, 3, 1) == Axis("P", [3])


def test_changes_override_entry_by_entry_a_scan_or_a_file():
    plain = load_scan(MINIMAL)
    assert load_scan(plain) is plain
    above = {"set": {"P": 1}, "sampling": {"periods": 7}, "record": {"want": ["energy"]}}
    request = load_scan(plain, above)
    assert request.system.parameters["P"] == 1
    assert (request.transient, request.periods) == (600, 7)
    assert request.want == ("energy",)
    assert request.axes == plain.axes
    changes = {"set": {"P": 1}, "start": {"policy": "up"}}
    assert load_scan(plain, changes) == load_scan(MINIMAL, changes)


def test_what_cannot_be_had_in_a_scene_is_left_out_while_something_remains(error_of):
    document = {**MINIMAL, "record": {"want": ["impacts", "energy"]}}
    assert load_scan(document, {"system": "tmd"}).want == ("energy",)
    assert load_scan({**document, "system": "tmd"}).want == ("energy",)
    asked = {"system": "tmd", "record": {"want": ["clearance", "section"]}}
    assert load_scan(document, asked).want == ("section",)
    for want in (["impacts"], ["clearance", "impacts"]):
        tmd = {**MINIMAL, "system": "tmd", "record": {"want": want}}
        assert "want 'impacts' cannot be had" in error_of(load_scan, tmd)


def test_a_title_that_is_true_no_more_is_replaced():
    document = {**MINIMAL, "title": "Figure 8"}
    assert load_scan(document, {"sampling": {"periods": 9}}).title == "Figure 8"
    assert load_scan(document, {"set": {"P": 5}}).title == "SSul NES, Set 6, P = 5 N: ω"
    assert load_scan(document, {"system": "tmd"}).title == "Tuned mass damper: ω"
    assert load_scan(document, {"set": {"P": 5}, "title": "mine"}).title == "mine"
    varied = load_scan({**document, "set": {"P": 800}}, {"vary": {"P": {"values": [1.0]}}})
    assert (varied.title, varied.axes) == ("SSul NES, Set 6: P", (Axis("P", [1.0]),))
    overridden = load_scan({**document, "set": {"E2": 1e7}}, {"set": {"K": 5}})
    assert overridden.title == "SSul NES, Set 6, K = 5 N/m^1.5: ω"


MANY = {"start": 1, "stop": 2, "num": 20_000}


def spectra(**settings):
    return {"record": {"want": ["spectrum"]}, "spectrum": settings}


@pytest.mark.parametrize(
    ("below", "above", "message"),
    [
        ({"set": {"omega": 6}}, {}, r"^scan: \[set\]: omega = 6: omega is varied by scan: \[v"),
        ({}, {"set": {"omega": 6}}, r"^changes: \[set\]: omega = 6: omega is varied by scan: \[v"),
        ({"set": {"E2": 1e7}, "vary": {"K": {"values": [1]}}}, {}, r"\[set\]: K beside E2"),
        ({"set": {"K": 1e7}, "vary": {"E2": {"values": [1]}}}, {}, r"\[set\]: K beside E2"),
        ({}, {"system": "tmd", "set": {"C": 1}}, r"^changes: \[set\]: kind 'tmd' has no"),
        ({}, {"vary": {"m1": {"values": [-1]}}}, r"^changes: \[vary\]: m1 = -1\.0 is not"),
        ({}, {"vary": {"P": MANY, "C": MANY}}, "400000000 orbits; allowed: up to 100000000"),
        ({}, spectra(signals=["x3"]), "unknown signal 'x3'"),
        ({}, spectra(signals=["force"]), "unknown signal 'force'"),
        ({}, spectra(signals=["x1", "x1"]), "names something twice"),
        ({}, spectra(highest=33.0), "allowed: up to half of the samples"),
    ],
)
def test_contradictions_and_what_cannot_be_recorded_are_refused(below, above, message):
    with pytest.raises(RequestError, match=message):
        load_scan({**MINIMAL, **below}, above)


@pytest.mark.parametrize(
    ("axes", "message"),
    [
        ((Axis("P", [1]), Axis("P", [2])), "varied parameters: P, P"),
        ((Axis("D", [1]),), "kind 'ssul' has no parameter 'D'"),
        ((Axis("omega", [-1, 1]),), "omega = -1.0 is not allowed"),
        ((Axis("nu1", [0.1, 0.2, 0.6]),), "nu1 = 0.6 is not allowed"),
        ((Axis("A", [0, 1, 2]), Axis("B", [0, 1, 2])), "A + B must be > 0"),
    ],
)
def test_a_scan_checks_its_axes(axes, message, error_of):
    assert message in error_of(dataclasses.replace, load_scan(MINIMAL), axes=axes)


NUMBERS = st.floats(1e-3, 1e3)
LETTERS = st.characters(exclude_categories=["Cc", "Cs", "Zl", "Zp"])
"""Characters that titles and names may hold: no control characters, halves, or line ends."""

WORDS = st.text(LETTERS, min_size=1, max_size=20)


@st.composite
def scans(draw) -> Scan:
    system = load_system(draw(st.sampled_from(list(catalog()))))
    scene, parameters = system.scene, sorted(set(system.scene.parameter_names))
    names = draw(st.lists(st.sampled_from(parameters), min_size=1, max_size=2, unique=True))
    overrides = draw(st.dictionaries(st.sampled_from(parameters), NUMBERS, max_size=4))
    for name, numbers in (("K", NUMBERS), ("e", st.floats(0.0, 1.0))):
        if name in scene.allowed and draw(st.booleans()):
            overrides[name] = draw(numbers)
    values = st.lists(NUMBERS, min_size=1, max_size=5, unique=True).map(sorted)
    states, seeds = st.tuples(*[NUMBERS] * len(scene.components)), st.integers(0, 2**63 - 1)
    starts = (
        st.builds(Start, st.sampled_from(["rest", "up", "down"])),
        st.builds(Start, st.just("state"), state=states),
        st.builds(Start, st.just("random"), st.integers(1, 99), seeds),
    )
    start = draw(st.one_of(*starts))
    possible = records.possible_want(records.WANTS, scene)
    possible = records.plain(possible) if start.sweeps else possible
    words = {"title": draw(WORDS), "name": draw(WORDS)}
    words["assumptions"] = {draw(st.sampled_from(parameters)): draw(WORDS)}
    return Scan(
        title=draw(WORDS),
        system=dataclasses.replace(system.with_(**overrides), **words),
        axes=tuple(Axis(name, draw(values)) for name in names),
        want=tuple(draw(st.lists(st.sampled_from(possible), min_size=1, unique=True))),
        start=start,
        transient=draw(st.integers(0, 10**9)),
        periods=draw(st.integers(1, 10**9)),
        method=draw(st.sampled_from(METHODS)),
    )


@settings(max_examples=200, deadline=None)
@given(scans())
def test_canonical_text_reads_back_to_an_equal_scan(original):
    again = load_scan(tomllib.loads(original.to_toml()))
    assert again == original
    assert again.hash == original.hash
    assert again.to_toml() == original.to_toml()
    assert again.cells().tobytes() == original.cells().tobytes()


def test_hash_ignores_words_and_sees_whatever_changes_numbers():
    base = load_scan(MINIMAL)
    renamed = dataclasses.replace(base.system, name="x", title="y", assumptions={"P": "z"})
    assert dataclasses.replace(base, title="other").hash == base.hash
    assert dataclasses.replace(base, system=renamed).hash == base.hash
    changes = [
        {"system": "ssul-set5"},
        {"set": {"P": 800.0000000000001}},
        {"vary": {"omega": {"values": [5.0, 6.000000000000001]}}},
        {"vary": {"C": {"values": [5.0, 6.0]}}},
        {"start": {"policy": "up"}},
        {"start": {"policy": "random", "count": 1}},
        {"sampling": {"transient": 601}},
        {"sampling": {"periods": 121}},
        {"sampling": {"method": "rk4"}},
        {"record": {"want": ["section"]}},
    ]
    assert len({base.hash, *(load_scan(MINIMAL, change).hash for change in changes)}) == 11


def test_draws_depend_on_the_seed_alone_and_no_other_starts_are_counted(error_of):
    def draws(count, seed):
        return start_states(Start("random", count, seed))

    assert draws(7, 3).shape == (7, 4)
    assert np.array_equal(draws(7, 3), draws(7, 3))
    assert np.array_equal(draws(9, 3)[:7], draws(7, 3))
    assert not np.array_equal(draws(7, 4), draws(7, 3))
    many = draws(10_000, 0)
    assert -1 <= many.min() < -0.99
    assert 0.99 < many.max() < 1
    # only random starts are counted, and both sweeps are two
    for wrong in ({"policy": "up", "count": 2}, {"policy": "both", "count": 2}, {"seed": 1}):
        assert "count and seed" in error_of(Start, **wrong)
    both = Start("both")
    assert (both.orbits, both.names, both.sweeps) == (2, ("up", "down"), ("up", "down"))
    assert (Start("rest").orbits, Start("rest").sweeps) == (1, ())
    assert Start("random", 3).names == ("random 0", "random 1", "random 2")


def test_random_states_measure_in_static_deflections():
    scan = load_scan({**MINIMAL, "set": {"C": 9}})  # so far away that nothing is held back
    states = random_states(scan.cells(), np.array([[0.5, -0.5, 0.25, 1.0]]), scan.system.scene)
    length = 800 / 3.95e4
    assert states.shape == (2, 1, 4)
    for omega, state in zip((5.0, 6.0), states[:, 0], strict=True):
        expected = [2.5 * length, -2.5 * length * omega, 3.75 * length, 15 * length * omega]
        assert state == pytest.approx(expected)


@pytest.mark.parametrize("near", [0.02, 0.0, -0.03])
def test_random_states_stay_between_the_walls(near):
    cells = np.zeros(3, CELL)
    cells["m1"], cells["k1"], cells["P"], cells["omega"] = 1000, 39500, 800, 6
    cells["near"], cells["far"] = near, 0.1
    draws = np.random.default_rng(1).uniform(-1, 1, (500, 4))
    both_walls = dataclasses.replace(SCENES["ssul"], gap_far=lambda p: p["V"])
    scenes = both_walls, SCENES["ssul"], SCENES["tmd"]
    two, one, free = (random_states(cells, draws, scene)[..., 2] for scene in scenes)
    assert (two.min(), two.max(), one.max()) == (-0.1, near, near)
    assert one.min() < -0.25
    assert free.min() < -0.25 < 0.25 < free.max()


def test_random_states_are_finite_and_differ_in_every_limit():
    limits = [0.0, 800.0, 1e-300], [0.0, 1e-300, 39500.0], [0.0, 0.06], [1e-200, 6.0, 1e200]
    cells = np.zeros((3, 3, 2, 3), CELL)
    for name, values in zip(("P", "k1", "near", "omega"), np.ix_(*limits), strict=True):
        cells[name] = values
    cells["m1"] = 1000
    draws = np.random.default_rng(1).uniform(-1, 1, (5, 4))
    states = random_states(cells, draws, SCENES["ssul"])
    assert states.shape == (3, 3, 2, 3, 5, 4)
    assert np.all(np.isfinite(states))
    assert np.all(np.abs(states[..., 0]) > 0)
    assert np.all(np.diff(np.sort(states[..., 0])) > 0)


MAPS = sorted([*REPO.glob("scans/map-*.toml"), *REPO.glob("scans/special-*.toml")])


@pytest.mark.parametrize("path", MAPS, ids=lambda path: path.stem)
def test_the_scans_of_maps_are_sound_and_can_be_drawn(path):
    scan = load_scan(path)
    recorded = quantities(scan.table.datasets.values(), scan.system.scene.components)
    assert scan.system.kind == "ssul"
    values = [axis.values for axis in scan.axes]
    wanted = ["settling", *(["shares"] if scan.starts > 1 and is_map(values) else [])]
    for show in wanted:
        check_show(show, values, scan.starts, recorded, "label" in scan.table.datasets)


@pytest.mark.parametrize("kind", ["ssvi-b", "ssvi-c"])
def test_random_states_beyond_a_limit_are_mirrored_at_it(kind):
    numbers = {**catalog()["ssbl"].parameters, **({"L": 0.01} if kind == "ssvi-c" else {})}
    cells = np.atleast_1d(System(kind, numbers).cells())
    limit = cells["limit"][0]
    unit = random_states(cells, np.array([[0.0, 0.0, -1e-3, 0.0]]), SCENES[kind])[0, 0, 2] / -1e-3
    places = limit * np.array([0.8, 1.2, 1.0, 0.3, 1.7])
    draws = np.zeros((5, 4))
    draws[:, 2] = places / unit
    r = random_states(cells, draws, SCENES[kind])[0, :, 2]
    np.testing.assert_allclose(r / limit, [0.8, 0.8, 1.0, 0.3, 0.3], rtol=1e-12)


@pytest.mark.parametrize("policy", ["up", "down", "both"])
def test_an_axis_that_is_followed_stays_whole(policy):
    long = {"transient": 10**6, "periods": 10**5}
    vary = {"K": {"values": [1e6, 1e7, 1e8]}, "omega": {"start": 5.0, "stop": 8.0, "num": 40}}
    for start, count in ((policy, 3), ("rest", 120)):
        changes = {"vary": vary, "start": {"policy": start}, "sampling": long}
        blocks = list(blocks_of(load_scan({"system": "ssul-set6"}, changes)))
        assert len(blocks) == count
        assert sum(block.cells for block in blocks) == 120


def test_failures_and_systems_are_told_in_words():
    fine, stiff = records.OK, records.TOO_STIFF
    status = np.array([[fine, stiff, records.DIVERGED], [stiff, fine, fine]])
    words = records.failures_in_words(records.failures_in(status), 400)
    assert words.startswith("3 of 400 orbits failed: 1 diverged (Check masses")
    assert "; 2 too_stiff (Raise omega" in words
    assert records.failures_in_words(records.failures_in(np.array([records.OK])), 1) == ""
    words = nv.load_system("bouncing-ball").parameters_in_words(["Y"])
    assert words == "ball under restitution: m = 1, g = 1, omega = 1.6, e = 0.15"
    assert nv.load_system("none").parameters_in_words().startswith("none: m1 = 1000, k1 = 39500")


def test_a_damper_without_spring_and_dashpot_is_searched_no_longer_than_another(tmp_path):
    """The factor k2 (x2 - rest) + ... of dE2/dt is then zero throughout, and so has no root."""

    def seconds(name, **settings):
        want, vary = ("section", "impacts", "energy", "regime"), {"omega": [6.0, 6.28]}
        scan = scan_of("ssul-set6", want, vary, changes=settings, transient=0, periods=200)
        began = time.process_time()
        path = nv.scan(scan, to=tmp_path / name)
        with nv.read(path) as archive:
            assert np.isfinite(archive["E2max"]).all()
        return time.process_time() - began

    usual = [seconds(f"{i}.h5", k2=668.9) for i in range(2)][-1]  # the first may have to compile
    assert seconds("free.h5", k2=0.0, c2=0.0) < 10 * usual + 1.0
