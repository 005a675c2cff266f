"""Scans of hosts: their cells beside `simulate` and beside kinds, sweeps, starts, refusals."""

import re

import numpy as np
import pytest
from support import as_host

import nlds_vines as nv
from nlds_vines.archives.archive import read
from nlds_vines.archives.files import toml_text
from nlds_vines.bifurcation.blocks import blocks_of
from nlds_vines.bifurcation.picture.choices import group, quantities_in, usual_places
from nlds_vines.bifurcation.request import Scan
from nlds_vines.bifurcation.run import Computer
from nlds_vines.engine.starts import Start
from nlds_vines.kernels.scene.codes import BAD_PARAMETERS, OK
from nlds_vines.model.axis import Axis
from nlds_vines.plotting.style import axis_label, setting_label
from nlds_vines.runs.executors import use_threads
from nlds_vines.scans.block import Block
from scans import archived, computed

pytestmark = pytest.mark.kernels

WANT = ("section", "impacts", "impact_section")
SPAN = {"transient": 40, "periods": 30}


def frame(law="restitution", k=0.0, c=0.0, **constants):
    """Return a frame of three storeys with one cell between two walls, and one with a single."""
    host = nv.shear_frame([1e4] * 3, [8e6] * 3, ratio=0.01)

    def cell(name, m, sides):
        walls = [nv.Wall(0.01, side, law=law, **constants) for side in sides]
        return nv.Damper(name, attached_to="roof", m=m, k=k, c=c, walls=walls)

    dampers = [cell("a", 300.0, "+-"), cell("b", 200.0, "-")]
    return nv.System.from_host(host, dampers, force={"roof": 1500.0}, omega=12.59)


RIGID, REST = frame(e=0.6), Start()


def scan_of(axes, want=WANT, start=REST, system=RIGID, **settings):
    axes = tuple(Axis(name, values) for name, values in axes.items())
    return Scan("frame", system, axes, want, start, **SPAN | settings)


def test_spectra_are_those_of_an_orbit_of_a_cell():
    """Amplitudes, lines and broadband shares beside `nv.spectrum` and a Fourier sum."""
    signals = ("roof", "roof-floor1", "roof.v")
    want = ("spectrum", "lines", "broadband")
    scan = scan_of({"omega": [12.0, 12.6]}, want, signals=signals, samples=32, highest=4.0)
    assert scan.table.datasets["spectrum"].units == "m, m/s"
    arrays = computed(scan)
    for i, omega in enumerate((12.0, 12.6)):
        orbit = nv.simulate(
            RIGID.with_(omega=omega), 30, transient=40, samples=32,
            record=["trajectory"], quiet=True,
        )  # fmt: skip
        for j, name in enumerate(signals):
            values = orbit.system.signal(name).of(orbit.trajectory)
            terms = values @ np.exp(-2j * np.pi * np.outer(np.arange(960), np.arange(1, 121)) / 960)
            whole = nv.spectrum(orbit, signal=name, window="hann")
            np.testing.assert_array_equal(arrays["spectrum"][i, 0, j], whole.amplitude[:121])
            assert arrays["broadband"][i, 0, j] == whole.background_share(121)
            if arrays["line_period"][i, 0] == 1:
                lines = 2 * np.abs(terms[29::30]) / 960
                np.testing.assert_allclose(
                    arrays["line_amplitude"][i, 0, j, :4], lines, rtol=1e-9, atol=1e-15
                )


def test_spectra_of_a_host_are_those_of_the_kind():
    """Of both formulations of one system, from rest; only the mean of u has the offset at rest."""
    kind = nv.load_system("ssul-set6").with_(omega=7.0)
    found = []
    for system, signals in ((kind, ["x1", "u"]), (as_host(kind), ["x", "u.stroke"])):
        scan = nv.scan(
            system, vary={"omega": [7.0]}, record=["spectrum", "broadband"], quiet=True,
            sampling={"transient": 300, "periods": 60}, spectrum={"signals": signals},
        )  # fmt: skip
        found.append((scan["spectrum"][0, 0, :, 1:], scan["spectral_label"].item()))
    (of_kind, label), (of_host, other) = found
    assert of_host == pytest.approx(of_kind, rel=1e-6, abs=1e-9 * of_kind.max())
    assert label == other


def test_the_modulation_of_displacements_is_that_of_the_section():
    scan = scan_of({"omega": [12.0, 12.6]}, ("modulation",), of=["roof", "roof-floor1"])
    arrays = computed(scan)
    assert scan.table.datasets["amplitude_ratio"].tail == ("displacement",)
    assert not {"two_impacts", "capture"} & arrays.keys()
    for i, omega in enumerate((12.0, 12.6)):
        section = nv.simulate(RIGID.with_(omega=omega), 30, transient=40, quiet=True).section
        roof, below = section[:, 4:6], section[:, 0:2]
        for j, motion in enumerate((roof, roof - below)):
            sizes = np.hypot(motion[:, 0], motion[:, 1] / omega)
            assert arrays["amplitude_min"][i, 0, j] == pytest.approx(sizes.min(), rel=1e-13)
            assert arrays["amplitude_max"][i, 0, j] == pytest.approx(sizes.max(), rel=1e-13)
            ratio = sizes.min() / sizes.max()
            assert arrays["amplitude_ratio"][i, 0, j] == pytest.approx(ratio, rel=1e-13)


def test_a_steady_motion_has_the_ratio_one_and_beats_have_that_of_their_amplitudes():
    """Undamped, x = A cos(omega t) + (x0 - A) cos(omega_0 t), in the section over long times."""
    host, omega = nv.chain([1.0], [1.0]), np.sqrt(1.7)
    system = nv.System.from_host(host, force={"x1": 1.0}, omega=omega)
    A = 1.0 / (1.0 - omega**2)
    steady = scan_of({"omega": [omega]}, ("modulation",), Start("state", state=(A, 0.0)), system)
    assert computed(steady)["amplitude_ratio"][0, 0] == pytest.approx(1.0, abs=1e-8)
    free = -2.0 * A
    start = Start("state", state=(A + free, 0.0))
    beating = scan_of({"omega": [omega]}, ("modulation",), start, system, periods=2000)
    angle = np.linspace(0.0, 2 * np.pi, 100_001)
    sizes = np.hypot(A + free * np.cos(angle), free * np.sin(angle) / omega)
    ratio = sizes.min() / sizes.max()
    assert computed(beating)["amplitude_ratio"][0, 0] == pytest.approx(ratio, abs=1e-4)


def test_a_cell_is_an_orbit_of_simulate():
    scan = scan_of({"omega": [12.0, 12.6], "a.gap": [0.006, 0.012]})
    arrays = computed(scan)
    assert scan.table.datasets["impacts_by_wall"].tail == ("damper", "wall")
    for place in np.ndindex(2, 2):
        values = {axis.name: axis.values[i] for axis, i in zip(scan.axes, place, strict=True)}
        orbit = nv.simulate(RIGID.with_(**values), 30, transient=40, quiet=True)
        impacts = orbit.impacts
        assert (arrays["section"][place][0] == orbit.section).all()
        assert arrays["impact_rate"][place][0] == len(impacts) / 30
        speeds = arrays["impact_speed"][place][0]
        assert (speeds[: len(impacts)] == impacts["speed"]).all()
        words = list(scan.table.datasets["impact_wall"].flags)
        walls = [words[code] for code in arrays["impact_wall"][place][0][: len(impacts)]]
        assert walls == [f"{one}{side}" for one, side in impacts[["damper", "wall"]].tolist()]
        rates, counts = (
            arrays[name][place][0] for name in ("impact_rate_by_wall", "impacts_by_wall")
        )
        is_periodic = arrays["periodicity"][place][0] > 0
        assert (arrays["impact_count"][place][0] >= 0) == is_periodic
        for i, damper in enumerate("ab"):
            for j, side in enumerate("+-"):
                is_here = (impacts["damper"] == damper) & (impacts["wall"] == side)
                assert rates[i, j] == is_here.sum() / 30
                if (damper, side) != ("b", "+"):  # which is not there
                    assert (counts[i, j] >= 0) == is_periodic
    assert arrays["impact_rate"].max() > 2.0


def test_initial_conditions_and_the_phase_are_those_of_a_kind(tmp_path):
    system = nv.load_system("ssul-set6", omega=6.28)
    places = np.array([-0.2, 0.01, 0.05])  # from the rest of the mass; the first is in the wall
    axes = {"x2_0": system.rest + places, "v2_0": [-1.0, 2.0]}
    start, span = Start("state", state=(0.01, 0.2, 0.0, 0.0), phase=2.0), {"transient": 0}
    kind = scan_of(axes, ("section",), start, system, **span)
    axes = {"u_0": places, "v_u_0": [-1.0, 2.0]}
    host = scan_of(axes, ("section",), start, as_host(system), **span)
    assert host.starts_inside() == kind.starts_inside()
    states, expected = computed(host)["section"], computed(kind)["section"]
    states[..., 2] += system.rest
    np.testing.assert_allclose(states[..., :10, :], expected[..., :10, :], rtol=0, atol=1e-8)
    assert np.ptp(expected[..., 0, 0]) > 1e-3
    path = archived(tmp_path / "x.h5", host, computed(host))
    orbit = nv.orbit_of(path, u_0=0.05, v_u_0=2.0)
    assert (orbit.section == computed(host)["section"][2, 1, 0]).all()


def test_a_phase_that_varies_is_time_that_has_passed():
    axes = {"phase": [0.0, np.pi, 2 * np.pi], "v_roof_0": [0.3]}
    sections = computed(scan_of(axes, ("section",), transient=0))["section"][:, 0, 0]
    orbit = nv.simulate(RIGID, 1, start=[0.0] * 5 + [0.3] + [0.0] * 4, quiet=True)
    assert (sections[0, 0] == orbit.section[0]).all()
    assert (sections[2] == sections[0]).all()
    # half a period later the force has the other sign
    later = nv.simulate(RIGID.with_(**{"force.roof": -1500.0}), 1, samples=2, quiet=True,
                        start=[0.0] * 5 + [0.3] + [0.0] * 4, record=["trajectory"])  # fmt: skip
    begun = computed(scan_of(axes, ("section",), transient=0, periods=1))
    half = nv.simulate(RIGID, 1, start=later.trajectory[0], quiet=True).section[0]
    np.testing.assert_allclose(begun["section"][1, 0, 0, 0], half, rtol=0, atol=1e-11)


def test_sweeps_and_threads():
    """A sweep follows the orbit before, put on a rigid wall that has come nearer."""
    scan = scan_of({"omega": [12.5, 12.6], "a.gap": [0.006, 0.008, 0.01]}, start=Start("both"))
    arrays = computed(scan)
    state = None
    for place in reversed(range(3)):
        system = RIGID.with_(**{"omega": 12.6, "a.gap": scan.axes[1].values[place]})
        if state is not None:
            r = state[4] - state[6]  # of the roof and the cell a, moved about their center of mass
            limit = system.dampers[0].walls[0].gap
            excess = r - np.clip(r, -limit, limit)
            state[4] -= 300.0 / 10_300.0 * excess
            state[6] += 10_000.0 / 10_300.0 * excess
        orbit = nv.simulate(system, 30, transient=40, start=state, quiet=True)
        difference = np.abs(arrays["section"][1, place, 1] - orbit.section).max()
        assert difference < 1e-9, place
        state = orbit.state.copy()
    assert np.abs(arrays["section"][1, 0, 0] - arrays["section"][1, 0, 1]).max() > 1e-9
    pieces = []
    use_threads(1)
    try:
        for block in [Block(0, ((0, 1), (0, 3))), Block(1, ((1, 2), (0, 3)))]:
            pieces.append(Computer(scan).block(block))
    finally:
        use_threads(None)
    for name, whole in arrays.items():
        np.testing.assert_array_equal(whole, np.concatenate([one[name] for one in pieces]), name)
    assert len(blocks_of(scan)) == 1


def test_random_starts_lie_between_the_walls():
    scan = scan_of({"a.gap": [0.001, 0.1]}, ("section",), Start("random", 6, 5))
    states = computed(scan)["start_state"]
    r = states[..., 4, np.newaxis] - states[..., [6, 8]]
    assert (np.abs(r[0, :, 0]) <= 0.001 * (1 + 1e-12)).all()
    assert (np.abs(r[1, :, 0]) > 0.001).any()
    assert (r[..., 1] >= -0.01 * (1 + 1e-12)).all()
    assert np.abs(states[0, :, 4]).max() > 0.0
    np.testing.assert_array_equal(states[0][:, [0, 2, 4]], states[1][:, [0, 2, 4]])


def test_archives_hold_the_request_and_the_same_bits(tmp_path):
    """As a file, on the command line, in pieces of one sweep each, and orbit by orbit."""
    file = tmp_path / "frame.toml"
    file.write_text(toml_text({"system": RIGID.to_table()}))
    axes = {"omega": {"values": [12.5, 12.6]}, "a.gap": {"values": [0.006, 0.008, 0.01]}}
    how = {"vary": axes, "record": list(WANT), "start": "both", "sampling": SPAN, "quiet": True}
    first, second = (nv.scan(source, to=tmp_path / f"{i}.h5", **how) for i, source in
                     enumerate((file, RIGID)))  # fmt: skip
    assert first.request.hash == second.request.hash
    assert first.request.system.parameters == RIGID.parameters
    with first.read() as one, second.read() as other:
        assert one.text("title") == "3 degrees of freedom, 2 dampers: ω, gap of a"
        for name in one.names:
            np.testing.assert_array_equal(one[name], other[name])
        assert (list(one["damper"]), list(one["wall"])) == (["a", "b"], ["+", "-"])
        assert one.dims("section")[-1] == "component"
        assert one.attrs["b.m"] == 200.0
        section = one["section"]
    for start, lane in (("up", 0), ("down", 1)):
        orbit = nv.orbit_of(first, omega=12.6, start=start, quiet=True, **{"a.gap": 0.008})
        assert (orbit.section == section[1, 1, lane]).all()
    data = first.to_xarray()
    assert data["impacts_by_wall"].sel(damper="b", wall="+").max() == 0
    cell = {"at": {"omega": 12.6, "a.gap": 0.008}, "start": "down", "samples": 16}
    nv.orbit_portrait(first, to=tmp_path / "cell.h5", panels=["relative"], quiet=True, **cell)
    view = nv.open_archive(tmp_path / "cell.h5").views[0]
    assert (view.section == section[1, 1, 1]).all()
    traced = nv.simulate(view.column.system, 1, start=view.section[-2], samples=16,
                         record=["trajectory"], quiet=True)  # fmt: skip
    np.testing.assert_allclose(view.states[-16:], traced.trajectory, rtol=1e-9, atol=1e-12)


def test_energies_and_responses_are_those_of_simulate(tmp_path, error_of):
    want, of = ("impacts", "energy", "response"), ("roof", "roof-floor2", "a")
    scan = scan_of({"omega": [12.0, 12.6]}, want, of=of)
    arrays = computed(scan)
    assert scan.table.datasets["E2max"].tail == ("damper",)
    assert scan.table.datasets["a_max"].tail == ("displacement",)
    system = RIGID.with_(omega=12.6)
    orbit = nv.simulate(system, 30, transient=40, record=["energy", "response"], of=of, quiet=True)
    assert arrays["E1max"][1, 0] == orbit.E1max > 0.0
    assert (arrays["E2max"][1, 0] == orbit.E2max).all()
    for i, name in enumerate(of):
        for quantity in ("x_max", "x_rms", "a_max"):
            assert arrays[quantity][1, 0, i] == orbit.response[f"{name}.{quantity}"]
    assert scan.table.datasets["impulse_max"].tail == ("damper",)
    for i, damper in enumerate(RIGID.dampers):
        assert arrays["impulse_max"][1, 0, i] == orbit.response[f"{damper.name}.impulse_max"]
    assert arrays["impulse_max"][1, 0, 0] > 0.0
    path = archived(tmp_path / "x.h5", scan, arrays)
    with read(path) as view:
        drawn = quantities_in(view)
        assert {"E1max", "a.E2max", "b.E2max", "roof-floor2.x_max", "a.a_max"} <= drawn.keys()
        assert drawn["b.impulse_max"].label == "largest impulse, b [N s]"
        assert drawn["b.E2max"].of(view)[1, 0] == orbit.E2max[1]
        assert drawn["roof.x_max"].label == "largest displacement, roof [m]"
        assert drawn["E1max"].label.startswith("energy of the host ")
        np.testing.assert_array_equal(view["roof-floor2.x_max"], arrays["x_max"][..., 1])
        np.testing.assert_array_equal(view["b.E_max"], arrays["E2max"][..., 1])
        np.testing.assert_array_equal(view["host.E_max"], arrays["E1max"])
        table = view.to_dataframe("a.a_max", "b.E2max")
        assert table.columns.tolist() == ["omega", "start", "a.a_max", "b.E2max"]
        assert table["a.a_max"].tolist() == arrays["a_max"][:, 0, 2].tolist()
        assert table.attrs["units"]["a.a_max"] == "m/s^2"
        assert "floor9" in error_of(view.take, "floor9.x_max")
    usual = scan_of({"omega": [12.0]}, ("response",))
    assert usual.of == ("roof",)
    assert usual.to_toml() == nv.load_scan(usual.document()).to_toml()


def test_verdicts_are_those_of_classify(tmp_path):
    want = ("section", "impacts", "energy", "regime", "lyapunov", "settling", "evidence")
    axes, sprung = {"omega": [11.5, 12.3, 12.6]}, frame(k=1e4, c=60.0, e=0.6)
    how = {"transient": 300, "periods": 60, "effort": "quick"}
    scan = scan_of(axes, want, system=sprung, **how)
    arrays, size = computed(scan), len(sprung.scene.components)
    assert scan.table.shape("multipliers") == (3, 1, size, 2)
    for i, omega in enumerate(axes["omega"]):
        system = sprung.with_(omega=omega)
        regime = nv.classify(system, **how, quiet=True)
        cell = {name: values[i, 0] for name, values in arrays.items()}
        assert cell["label"] == regime.label
        assert (cell["periodicity"], cell["impact_count"]) == (regime.period, regime.impacts)
        assert cell["impact_rate"] == regime.impact_rate
        if regime.period:
            assert cell["impacts_by_wall"].sum() == regime.impacts
        assert (cell["settling"], cell["watched"]) == (regime.settling, regime.watched)
        np.testing.assert_array_equal(cell["lyapunov"], regime.lyapunov)
        np.testing.assert_array_equal(cell["exponents"], regime.exponents)
        if regime.period:
            np.testing.assert_array_equal(cell["orbit_point"], regime.point)
            pairs = cell["multipliers"]
            np.testing.assert_array_equal(pairs[:, 0] + 1j * pairs[:, 1], regime.multipliers)
        orbit = nv.simulate(system, 60, transient=300, quiet=True)
        assert (cell["section"] == orbit.section).all()
    labels = arrays["label"][:, 0].tolist()
    assert labels[0] == "T,0"
    assert re.fullmatch(r"[0-9]*T,[0-9]+ \([0-9]+\+[0-9]+\)", labels[2])
    path = archived(tmp_path / "x.h5", scan, arrays)
    texts = [text.get_text() for panel in nv.plot(path).axes for text in panel.texts]
    assert labels[2] in texts


def test_samples_of_hosts():
    samples = {"a.gap": [0.006, 0.03, -1.0], "b.m": [100.0, 200.0, 300.0]}
    scan = nv.scan(RIGID, samples=samples, record=["impacts"], sampling=SPAN, quiet=True)
    with scan.read() as view:
        assert view["status"].tolist() == [[OK], [OK], [BAD_PARAMETERS]]
        assert view["impact_rate"][0] > 0.0
        assert np.isnan(view["impact_rate"][2, 0])


def test_starts_inside_walls_are_told():
    state = [0.0] * 6 + [-0.02, 0.0] + [0.0] * 2  # the cell a, 10 mm inside its wall "+"
    start = Start("state", state=tuple(state))
    lines = scan_of({"a.gap": [0.01, 0.03]}, start=start).starts_inside()
    assert lines == ["1 of 2 starts is inside a wall and put on it, 10 mm deep at most"]
    assert scan_of({"a.gap": [0.01, 0.03]}).starts_inside() == []


def test_pictures_show_a_damper_and_what_it_hangs_on(tmp_path):
    scan = scan_of({"omega": [12.0, 12.6], "a.gap": [0.006]})
    path = archived(tmp_path / "x.h5", scan, computed(scan))
    with read(path) as view:
        drawn = quantities_in(view)
        assert usual_places(view, drawn) == ["a", "roof"]
        assert group("velocity", drawn)[0] == "v_b"
        assert drawn["v_roof"].label == "velocity of roof [m/s]"
        assert drawn["a.impacts_by_wall"].of(view).shape == (2, 1, 1, 2)
        labels = [panel.get_ylabel() for panel in nv.plot(path).axes]
        assert labels[:2] == ["displacement of a [m]", "displacement of roof [m]"]
        (legend,) = filter(None, (panel.get_legend() for panel in nv.plot(path).axes))
        words = [text.get_text() for text in legend.get_texts()]
        assert words == ["wall a+", "wall a-", "wall b-"]
        assert axis_label("a.gap+") == "gap at rest of a, wall + [m]"
        assert axis_label("a.k") == r"stiffness of the spring of a ${k}_{\mathrm{a}}$ [N/m]"
        assert setting_label("a.gap", 0.006) == r"$\mathrm{gap}_{\mathrm{a}}=0.006$ m"


@pytest.mark.parametrize(
    ("axes", "change", "text"),
    [
        ({"c.k": [1.0, 2.0]}, {}, "c.k"),
        ({"a.stiffness": [1.0, 2.0]}, {}, "stiffness"),
        ({"a.gap": [0.01], "a.gap+": [0.01]}, {}, "a.gap beside a.gap+: give one of them"),
        ({"a.m": [0.0, 2.0]}, {}, "a.m = 0.0 is not allowed"),
        ({"a.gap+": [-0.02, 0.1]}, {}, "overlap by 0.01 m"),
        ({"attic_0": [0.0, 1.0]}, {}, "unknown axis 'attic_0'; did you mean 'a_0'? allowed: a.m"),
        ({"roof_0": [0.0, 1.0]}, {"start": Start("up")}, "roof_0 is varied: orbits start at rest"),
        ({"omega": [12.0]}, {"method": "rk4"}, "unknown method 'rk4'"),
        ({"omega": [12.0]}, {"want": ("peak",)}, "want 'peak' cannot be had"),
        ({"omega": [12.0]}, {"want": ("spectrum",), "signals": ("attic",)}, "attic"),
        ({"omega": [12.0]}, {"want": ("spectrum",), "signals": ("E1",)}, "signal 'E1' is energy"),
        ({"omega": [12.0]}, {"of": ("roof",)}, "the response is not recorded"),
        ({"omega": [12.0]}, {"want": ("response",), "of": ("attic",)}, "attic"),
        ({"omega": [12.0]}, {"start": Start("state", state=(0.0, 1.0))}, "state has 2 numbers"),
    ],
)
def test_refusals_are_one_line(axes, change, text, error_of):
    assert text in error_of(scan_of, axes, **change)
