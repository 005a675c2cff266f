"""Portraits of hosts: archives beside `simulate` and beside kinds, panels, refusals."""

import numpy as np
import pytest
from layout import collisions

import nlds_vines as nv
from nlds_vines.portrait.picture import portrait
from nlds_vines.portrait.request import load_portrait
from nlds_vines.portrait.result import portrait_in
from nlds_vines.portrait.run import views_of

pytestmark = pytest.mark.kernels

FRAME = nv.shear_frame([1e4] * 3, [8e6] * 3, ratio=0.01)


def cell(name, m, gap, sides="+-", **law):
    walls = [nv.Wall(gap, side, **law or {"law": "restitution", "e": 0.6}) for side in sides]
    return nv.Damper(name, "roof", m=m, k=500.0, c=60.0, walls=walls)


def on_roof(*dampers, host=FRAME, dof="roof", omega=12.59):
    return nv.System.from_host(host, dampers, force={dof: 1500.0}, omega=omega)


PAIR = on_roof(cell("a", 300.0, 0.01), cell("b", 300.0, 0.015, K=3e7))
SPAN = {"samples": 32, "transient": 300, "periods": 8}


def request_of(system, sampling=SPAN, **portrait):
    return load_portrait(system, {"sampling": sampling, "portrait": portrait})


def test_an_archive_has_the_orbit_of_simulate(here, answer):
    request = request_of(PAIR, {"windows": [[300, 304], [306, 308]], "samples": 32},
                         signal=["roof", "b.force"])  # fmt: skip
    nv.orbit_portrait(request, to="pair.h5", quiet=True)
    stored = portrait_in("pair.h5")
    record = ["trajectory", "impacts", "energy"]
    orbit = nv.simulate(PAIR, 8, transient=300, samples=32, record=record, quiet=True)
    first, last = stored.views
    np.testing.assert_array_equal(first.states, orbit.trajectory[: 4 * 32])
    np.testing.assert_array_equal(last.states, orbit.trajectory[6 * 32 :])
    early = orbit.impacts[orbit.impacts["touch"] <= 304 * PAIR.period]
    assert (first.contacts == early).all()
    assert len(early) > 8
    for view, computed in zip(stored.views, views_of(request, quiet=True), strict=True):
        assert [*view.lines()] == [*computed.lines()]
        for one, other in zip(view.spectra, computed.spectra, strict=True):
            np.testing.assert_array_equal(one.amplitude, other.amplitude)
    with nv.read("pair.h5") as view:
        for name, most in (("E1", orbit.E1max), ("a.E2", orbit.E2max[0]), ("b.E2", orbit.E2max[1])):
            assert 0.97 * most < view[name].max() <= most * (1 + 1e-12)
        kn = np.abs(view["b.force"]).max()
        assert 0.5 * orbit.impacts["force"][orbit.impacts["damper"] == "b"].max() < kn
        gap = view["roof.x"] - view["a.x"]
        np.testing.assert_array_equal(view["a.stroke"], gap)
    assert "results are the same" in answer("rerun", "pair.h5")


def panels(system, **options):
    request = request_of(system, **options)
    figure = portrait(request, views_of(request, quiet=True))
    assert collisions(figure) == []
    return {axes.get_label(): axes for axes in figure.axes}


def test_panels_name_their_dampers_and_displacements():
    (phase,) = panels(PAIR, panels=["phase"], of=["roof", "floor2"]).values()
    assert {line.get_label() for line in phase.lines} == {"roof", "floor2", "$t=nT$"}
    drawn = panels(PAIR, panels=["relative", "phase2", "section", "shape", "impact-section"])
    assert [*drawn] == [*(f"{word}:{name}" for word in ("relative", "phase2", "section")
                          for name in "ab"), "shape", "impact-section"]  # fmt: skip
    for axes, gap in ((drawn["relative:a"], 0.01), (drawn["relative:b"], 0.015)):
        _, *walls, touches = axes.lines
        assert {line.get_ydata()[0] for line in walls} == {gap, -gap}
        assert {*np.abs(touches.get_ydata())} == {gap}
    (view,) = views_of(request_of(PAIR), quiet=True)
    low, high = (line.get_xdata() for line in drawn["shape"].lines if line.get_label() == "largest")
    states = view.states[-32 * view.cycle :, :6:2]
    np.testing.assert_array_equal((low, high), (states.min(axis=0), states.max(axis=0)))
    assert [text.get_text() for text in drawn["shape"].get_yticklabels()] == [*FRAME.dofs]


@pytest.mark.parametrize("ground", [False, True])
def test_hosts_without_dampers_have_the_panels_of_a_structure(ground):
    drive = {"base": {"acceleration": 0.1}} if ground else {"force": {"floor2": 900.0}}
    system = nv.System.from_host(FRAME, [], omega=12.0, **drive)
    drawn = panels(system, panels=["displacement", "energy", "section", "shape", "spectrum"])
    (curve,) = drawn["displacement"].lines
    assert curve.get_label() == ("roof" if ground else "floor2")
    assert "relative" not in panels(system, of=["roof", "floor1"])


def test_a_reduced_beam_shows_deflections_alone():
    strip = nv.beam(1.0, 65.6, 1.18, ratio=0.02).reduced(3, statics=["w20"])
    ball = nv.Damper("ball", "w20", m=0.06, k=40.0, c=0.3, walls=[nv.Wall(0.01, K=2e6)])
    system = nv.System.from_host(strip, [ball], force={"w20": 1.0}, omega=26.0)
    drawn = panels(system, of=["w20", "w20-w10"], panels=["displacement", "phase1", "shape"])
    assert [*drawn] == ["displacement", "phase1:w20", "phase1:w20-w10", "shape"]
    tip, bend = (line.get_ydata() for line in drawn["displacement"].lines)
    names = [text.get_text() for text in drawn["shape"].get_yticklabels()]
    assert names[-1] == "w20"
    assert all(name.startswith("w") for name in names)
    middle = tip - bend
    assert 0 < np.abs(middle).max() < 0.5 * np.abs(tip).max()


def test_an_orbit_of_a_host_plots_itself():
    orbit = nv.simulate(PAIR, 12, transient=100, quiet=True)
    labels = [axes.get_label() for axes in orbit.plot().axes]
    assert labels == ["displacement", "relative:a", "relative:b", "section:a", "section:b",
                      "impact-section"]  # fmt: skip


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"of": ["rooof"]}, "unknown displacement 'rooof'"),
        ({"panels": ["relative:c"]}, "panels relative:c cannot be filled"),
        ({"panels": ["relativ:a"]}, "unknown panels 'relativ:a'"),
        ({"signal": ["c.force"]}, "signal 'c.force': unknown damper 'c'"),
        ({"signal": ["roof.y"]}, "signal 'roof.y': unknown quantity 'y'"),
        ({"method": "rk4"}, "unknown method 'rk4'"),
        ({"start": [0.0]}, "allowed: rest, or floor1"),
    ],
)
def test_what_a_host_lacks_is_refused_in_one_line(error_of, options, words):
    assert words in error_of(nv.orbit_portrait, PAIR, **options)


def test_columns_differ_in_what_set_changes(error_of, here):
    document = {
        "system": PAIR.to_table(),
        "sampling": {**SPAN, "transient": 20},
        "column": [{"set": {"a": {"gap": 0.02}}}, {"set": {"a.attached_to": "floor2"}}],
    }
    request = load_portrait(document)
    assert len(request.runs()) == 2
    assert load_portrait(request.document()).hash == request.hash
    nv.orbit_portrait(request, to="both.h5", quiet=True)
    first, second = portrait_in("both.h5").views
    assert first.column.system.parameters["a.gap"] == 0.02
    assert second.column.system.dampers[0].attached_to == "floor2"
    assert "of = ['x1'] is for displacements of a host" in error_of(
        load_portrait, "tmd", {"portrait": {"of": ["x1"]}}
    )


def test_all_exponents_of_a_host_sum_to_the_divergence_of_its_flow(here):
    system = PAIR.with_(**{"a.gap": 1.0, "b.gap": 1.0})  # no wall is touched
    nv.orbit_portrait(system, panels=["exponents"], transient=20, to="all.h5", quiet=True)
    (view,) = portrait_in("all.h5").views
    host, size = system.host, len(system.scene.components)
    divergence = -np.trace(np.linalg.solve(host.M, host.C))
    rows = system.rows()
    masses = np.append(np.diag(host.M), [damper.m for damper in system.dampers])
    for damper, row in zip(system.dampers, rows, strict=True):
        divergence -= damper.c * (row * row / masses).sum()
    assert view.exponents.exponents.shape == (size,)
    assert view.exponents.exponents.sum() == pytest.approx(divergence, rel=1e-9)
    (axes,) = nv.plot("all.h5").axes
    assert axes.get_ylabel() == "exponents [1/s]"
