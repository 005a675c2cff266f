"""Response curves: dampers beside each other and the structure alone, in one archive."""

import tomllib

import numpy as np
import paper_results
import pytest
from matplotlib.colors import to_hex

import nlds_vines as nv
from nlds_vines.__main__ import main as console
from nlds_vines.bifurcation import response_curves
from nlds_vines.bifurcation.curves_command import main
from nlds_vines.bifurcation.picture.curves import draw_curves
from nlds_vines.engine.records import OK
from nlds_vines.model.labels import FLAGS
from nlds_vines.upkeep.rerun import differing
from paper.linear import response


def sampled(low, high, transient=200, periods=20):
    words = f"--vary omega={low}:{high}:7 --transient {transient} --periods {periods} --quiet"
    return words.split()


SHORT = sampled(6, 6.6)
PAGE = """
title = "two surfaces"
vary = { omega = { start = 6.0, stop = 6.6, num = 5 } }
sampling = { transient = 100, periods = 10 }
record = { want = ["impacts", "energy"] }
panels = [{ system = "ssul-set6", title = "unilateral" }, { system = "tmd" }]
curves = [
    { set = { c2 = 60.0 }, color = "blue" },
    { set = { c2 = 90.0 }, color = "vermillion", panel = 1 },
]
"""


@pytest.fixture
def here(here):
    (here / "page.toml").write_text(PAGE)
    return here


@pytest.fixture
def beside_a_scan(here):
    """Return a function that computes response curves and a scan of one of their systems."""

    def both(system, *words, record, sampling=SHORT, also=()):
        assert main(["--system", system, *also, *words, *sampling, "-o", "a.h5"]) == 0
        scan = ["bifurcation", "--system", system, "--record", record, *words, *sampling]
        assert console([*scan, "-o", "b.h5"]) == 0
        with nv.read("b.h5") as view:
            return nv.open_archive("a.h5"), {name: view[name] for name in view.names}

    return both


@pytest.mark.kernels
def test_dampers_are_compared_with_the_structure_alone(here, error_of):
    assert main(["--system", "tmd", "--system", "ssul-set6", *SHORT, "-o", "a.h5"]) == 0
    archive = nv.open_archive("a.h5")
    names = [response_curves.ALONE, "Tuned mass damper", "SSul NES, Set 6"]
    assert [curve.name for curve in archive.curves] == names
    bare, tmd = archive[response_curves.ALONE], archive["Tuned mass damper"]
    exact = response(nv.load_system("none"), bare.values).E1max
    np.testing.assert_allclose(bare.E1max, exact, rtol=1e-6)
    np.testing.assert_allclose(tmd["reduction"], 1 - tmd.E1max / exact, rtol=1e-9)
    assert tmd.peak == tmd.E1max.max()
    assert tmd.peak_at == tmd.values[tmd.E1max.argmax()]
    assert tmd.peak_reduction == pytest.approx(1 - tmd.peak / bare.peak, rel=1e-9)
    assert np.isnan(bare.peak_reduction)
    assert np.isnan(bare["reduction"]).all()
    assert np.isnan(bare["E2max"]).all()
    assert (archive["SSul NES, Set 6"]["impact_count"] > 0).any()
    assert not tmd.cycles().size
    assert "case = 'x' is not there; allowed: without damper" in error_of(archive.__getitem__, "x")
    assert "'y' is not recorded along curves; allowed: E1max" in error_of(tmd.__getitem__, "y")
    data = archive.to_xarray()
    assert data["E1max"].dims == ("system", "omega", "start")
    assert data["system"].values.tolist() == names
    upper, lower = archive.plot().axes  # the reduction stands below
    assert lower.get_ylabel() == "reduction [%]"
    zero, curve, *_ = lower.get_lines()
    assert set(zero.get_ydata()) == {0}
    np.testing.assert_array_equal(curve.get_ydata(), 100 * tmd["reduction"])
    assert upper.get_xlim() == lower.get_xlim() == (6.0, 6.6)


@pytest.mark.kernels
def test_the_archive_is_verified_repeated_and_redrawn(here, answer):
    assert main(["page.toml", "-o", "a.h5", "--plot", "a.png", "--quiet"]) == 0
    assert console(["rerun", "a.h5", "-o", "b.h5", "--quiet"]) == 0
    assert differing("a.h5", "b.h5") == []
    with nv.read("a.h5") as view:
        again = response_curves.load_curves(tomllib.loads(view.text("scan")))
    archive = nv.open_archive("a.h5")
    assert again.to_toml() == archive.request.to_toml()
    assert [case.panel for case in again.cases] == [1, 1, 2]
    first, second = archive.plot().axes
    assert first.get_title(loc="left") == "(a)  unilateral"
    colors = [to_hex(line.get_color()) for line in second.get_lines()[1:]]
    assert colors == [again.cases[2].color]


@pytest.mark.kernels
def test_curves_show_any_number_of_the_response(beside_a_scan):
    """Beside a scan of the same system, and the closed form of the structure alone."""
    shown = ["x1_max", "v1_rms", "stroke_max", "force_max"]
    also = ["--system", "tmd", "--show", ",".join(shown), "--log"]
    record = "impacts,energy,response"
    archive, one = beside_a_scan("ssbl", "--set", "P=1200", record=record, also=also)
    ssbl, tmd = archive["SSbl NES"].numbers, archive["Tuned mass damper"].numbers
    with nv.read("a.h5") as page:
        assert page["P"].tolist() == [1200.0] * 3
        assert page["system_name"].tolist() == ["none", "ssbl", "tmd"]
        assert np.isnan(page["C"][[0, 2]]).all()
        assert (page["status"] == OK).all()
    for name in (*shown[:3], "E1max", "E2max", "reduction", "impact_count"):
        assert ssbl[name].tolist() == one[name].tolist(), name
    assert ssbl["force_max"].tolist() == one["force_max"].max(axis=-1).tolist()
    assert np.isnan(tmd["force_max"]).all()
    p, bare = nv.load_system("none", P=1200).parameters, archive[response_curves.ALONE]
    omega = bare.values
    size = p["P"] / np.abs(p["k1"] - p["m1"] * omega**2 + 1j * omega * p["c1"])
    np.testing.assert_allclose(bare["x1_max"], size, rtol=1e-6)
    np.testing.assert_allclose(bare["v1_rms"], omega * size / np.sqrt(2), rtol=1e-6)
    panels = archive.plot().axes[: len(shown)]
    labels = ["largest displacement [m]", "rms velocity [m/s]", "largest stroke [m]",
              "largest contact force [N]"]  # fmt: skip
    assert [axes.get_ylabel() for axes in panels] == labels
    assert {axes.get_yscale() for axes in panels} == {"log"}
    for axes, name in zip(panels, shown, strict=True):
        drawn = [np.asarray(line.get_ydata()) for line in axes.lines]
        assert any(np.array_equal(line[np.isfinite(line)], ssbl[name][:, 0]) for line in drawn)


@pytest.mark.kernels
def test_two_sweeps_are_drawn_and_shaded_where_they_differ(beside_a_scan):
    archive, one = beside_a_scan(
        "ssul-set6", "--start", "both", record="energy,impacts", sampling=sampled(7.4, 7.7)
    )
    curve = archive["SSul NES, Set 6"]
    assert curve.numbers["E1max"].tolist() == one["E1max"].tolist()
    up, down = curve.numbers["E1max"].T
    highest = np.fmax(up, down)
    assert curve.peak == highest.max()
    assert curve.peak_at == curve.values[highest.argmax()]
    differ = np.abs(up - down) > 0.01 * highest.max()
    assert differ.any()
    assert not differ.all()
    differ |= curve.cycles() != curve.cycles(1)
    axes = archive.plot().axes[0]
    shaded = np.zeros(len(differ), dtype=bool)
    for patch in axes.patches:
        low, high = patch.get_x(), patch.get_x() + patch.get_width()
        shaded |= (curve.values > low) & (curve.values < high)
    assert shaded.tolist() == differ.tolist()


def test_sweeps_on_two_orbits_with_equal_energies_are_shaded():
    """In the third cell of five the sweeps are T,0 and T,2."""
    E1max, n, k = np.arange(1.0, 6.0), np.ones(5, int), np.zeros(5, int)
    numbers = {"E1max": E1max, "periodicity": n, "impact_count": k}
    numbers = {name: np.stack([array, array], axis=1) for name, array in numbers.items()}
    assert not axes_of(numbers, start={"policy": "both"}, reduction=False)[0].patches
    numbers["impact_count"][2, 1] = 2
    patches = axes_of(numbers, start={"policy": "both"}, reduction=False)[0].patches
    assert len(patches) == 2  # both curves of this page have the same numbers
    for patch in patches:
        assert patch.get_x() < 6.2 < patch.get_x() + patch.get_width()


@pytest.mark.kernels
def test_irregular_responses_are_shaded(here):
    document = {
        "system": "ssul-set6",
        "vary": {"omega": {"values": [7.3, 7.35, 7.4, 7.6, 7.65]}},
        "sampling": {"transient": 300, "periods": 60},
        "record": {"want": ["energy", "impacts", "regime"]},
        "set": {"K": 2.5e7},
        "curves": [{"label": "set 6"}],
    }
    curves = nv.response_curves(document, to="a.h5", quiet=True)
    regime = curves["set 6"]["regime"]
    patches = curves.plot().axes[0].patches
    irregular = [FLAGS[word] for word in ("chaotic", "quasiperiodic")]
    assert np.isin(regime, irregular).tolist() == [False, False, True, False, False]
    (patch,) = patches
    assert patch.get_x() < 7.4 < patch.get_x() + patch.get_width()


def test_any_archive_of_dampers_has_a_panel_of_reductions(tmp_path):
    """Also that of a figure whose picture has none, as Figures 2 and 3 of the paper."""
    curves = [{"system": "none"}, {"system": "tmd"}]
    vary = {"omega": {"values": [6.0, 6.1, 6.2]}}
    request = response_curves.load_curves({"vary": vary, "curves": curves})
    energies = {"E1max": np.array([3.0, 2.0, 1.0]), "reduction": np.array([0.1, 0.2, 0.3])}
    path = paper_results.write_curves(tmp_path / "a.h5", request, [energies, energies])
    archive = nv.open_archive(path)
    assert [axes.get_ylabel()[:6] for axes in archive.plot().axes] == ["energy"]
    (lower,) = archive.plot(show="reduction").axes
    assert lower.get_ylabel() == "reduction [%]"
    _, curve = [line for line in lower.get_lines() if line.get_marker() != "o"]
    assert curve.get_ydata().tolist() == [10.0, 20.0, 30.0]


def axes_of(numbers, start=None, **figure):
    """Return the axes of a picture of a damper with these numbers, and of the structure alone."""
    values = np.linspace(6.0, 6.4, len(numbers["E1max"])).round(3).tolist()
    tables = {"vary": {"omega": {"values": values}}, "figure": figure, "start": start or {}}
    request = response_curves.curves_from("ssul-set6", tables, "a test")
    numbers = {name: array.reshape(len(values), -1) for name, array in numbers.items()}
    curves = [response_curves.ResponseCurve("", case, numbers) for case in request.cases]
    return draw_curves(response_curves.ResponseCurves(None, request, curves)).axes


def test_no_line_joins_two_regimes():
    """T,1, a chaotic orbit, 3T,2 and T,1 again; of older archives, without periods, one line."""
    E1max = np.array([1.0, 2.0, 9.0, 5.0, 6.0, 3.0, 4.0])
    numbers = {"E1max": E1max, "reduction": 1.0 - E1max}
    numbers["periodicity"] = np.array([1, 1, 0, 3, 3, 1, 1])
    numbers["impact_count"] = np.array([1, 1, 7, 2, 2, 1, 1])
    (axes, reduction) = axes_of(numbers, reduction=True)
    for panel, values in ((axes, E1max), (reduction, 100.0 * (1.0 - E1max))):
        drawn = [line for line in panel.lines if line.get_linestyle() == "-"]
        up = [np.asarray(line.get_ydata()) for line in drawn if len(line.get_xdata()) > 2][-1]
        pieces = np.split(up, np.flatnonzero(np.isnan(up)))
        pieces = [piece[np.isfinite(piece)].tolist() for piece in pieces]
        assert pieces == [piece.tolist() for piece in np.split(values, [2, 3, 5])]
        dots = [line for line in panel.lines if line.get_marker() == "o"]
        assert dots[-1].get_xdata().tolist() == [6.133]
    del numbers["periodicity"]
    axes, _ = axes_of(numbers, reduction=True)
    assert axes.lines[-1].get_ydata().tolist() == E1max.tolist()


@pytest.mark.kernels
def test_archives_tell_regimes_along_curves_without_a_verdict(beside_a_scan):
    """The periods are those of a scan's verdicts; what has not settled in the window has none."""
    archive, one = beside_a_scan("ssul-set6", record="regime", sampling=sampled(7.2, 7.5, 400, 60))
    words = [label.rpartition(" ")[2].replace("T", "") for label in one["label"][:, 0].tolist()]
    words = [word if word[0].isdigit() else f"1{word}" for word in words]
    assert (one["periodicity"] > 0).all()
    cycles = archive["SSul NES, Set 6"].cycles()
    seen = cycles != ""
    assert np.count_nonzero(seen) >= 5
    assert cycles[seen].tolist() == np.array(words)[seen].tolist()
    assert len(set(cycles[seen])) > 1
    assert archive[response_curves.ALONE].cycles().size == 0


def test_a_curve_without_any_period_is_dots():
    """Chaos has no impacts per nT, as a structure without walls."""
    numbers = {"E1max": np.arange(1.0, 6.0), "periodicity": np.zeros(5, int)}
    numbers["impact_count"] = np.full(5, -1)
    axes = axes_of(numbers, reduction=False)[0]
    dots = [line for line in axes.lines if line.get_marker() == "o"]
    assert len(dots[-1].get_xdata()) == 5


def test_nothing_is_clipped_without_a_sign():
    """A reduction of -250 % is marked at the lower end of its panel; likewise zero in decades."""
    numbers = {"E1max": np.array([0.0, 20.0, 300.0]), "reduction": np.array([0.3, -2.5, -0.2])}
    energies, reduction = axes_of(numbers, reduction=True, log=True)
    for axes, place, words in (
        (energies, 6.0, "zero"),
        (reduction, 6.2, "below \N{MINUS SIGN}100 %"),
    ):
        (mark, *_) = [line for line in axes.lines if line.get_linestyle() == "None"]
        assert mark.get_xdata().tolist() == [place]
        assert mark.get_transform().transform((place, 0.0))[1] == pytest.approx(axes.bbox.y0)
        assert [text.get_text()[2:] for text in axes.texts if "▼" in text.get_text()] == [words]
    numbers["reduction"] = np.array([0.3, -0.99, -0.2])
    (_, reduction) = axes_of(numbers, reduction=True)
    assert not [line for line in reduction.lines if line.get_linestyle() == "None"]
    assert not [text for text in reduction.texts if "▼" in text.get_text()]


ALONG = {"vary": {"omega": {"values": [6.0, 6.2]}}, "curves": [{"system": "tmd"}]}


@pytest.mark.parametrize(
    ("tables", "words"),
    [
        ({"figure": {"show": ["force_max"]}}, "'force_max': no curve has it; allowed: E1max"),
        (
            {"figure": {"show": ["E1max", "x1_max"]}, "panels": [{}, {"title": "b"}]},
            "show: several quantities need one panel",
        ),
        ({"start": {"policy": "random", "count": 3}}, "allowed: rest, up, down, both"),
        (
            {
                "vary": {"mass_ratio": {"values": [0.05, 0.1]}},
                "curves": [{"system": "tmd"}, {"system": "tmd", "set": {"m1": 2000.0}}],
            },
            "curves along m2: all need the same parameter and values",
        ),
    ],
)
def test_what_cannot_be_shown_is_refused(tables, words, error_of):
    assert words in error_of(response_curves.load_curves, {**ALONG, **tables})


def test_what_is_shown_and_energies_are_recorded_and_nothing_twice():
    shown = {"figure": {"show": ["x1_rms", "E1max"]}, "record": {"want": ["impacts", "energy"]}}
    request = response_curves.load_curves({**ALONG, **shown})
    request = response_curves.with_structure_alone(request)
    assert all({"energy", "response"} <= {*case.scan.want} for case in request.cases)
    assert response_curves.load_curves(request.document()).hash == request.hash
    assert response_curves.load_curves(request.document()).show == ("x1_rms", "E1max")
    # energies are recorded even if no one asks, and nothing twice
    for want, recorded in (("regime", ("energy", "regime")), ("energy", ("energy",))):
        (case,) = response_curves.load_curves({**ALONG, "record": {"want": [want]}}).cases
        assert case.scan.want == recorded


def test_cases_of_one_page_have_different_names_and_looks():
    tmd = nv.load_system("tmd")
    request = response_curves.curves_from([tmd, tmd.with_(c2=50.0), "none"], {}, "a test")
    *two, alone = request.names
    assert two == ["Tuned mass damper", "Tuned mass damper, c₂ = 50 N s/m"]
    assert alone == "Primary structure alone"
    names = [f"ssul-set{i}" for i in range(1, 7)]
    request = response_curves.curves_from([*names, "tmd", "ssbl"], {}, "test")
    looks = [(case.color, case.line) for case in request.cases]
    assert len(set(looks)) == len(looks) == 9


@pytest.mark.kernels
def test_python_takes_systems_names_files_and_documents(here):
    sampling = {"transient": 20, "periods": 4}
    tables = {"vary": {"omega": {"values": [6.0, 6.3]}}, "sampling": sampling}
    mine = nv.load_system("tmd", c2=50.0)
    curves = nv.response_curves([mine, "tmd"], to="a.h5", set={"P": 400.0}, **tables)
    assert curves.request.title == "Response curves, P = 400 N, ω from 6 to 6.3 rad/s"
    assert len(curves.curves) == 3
    of_file = nv.response_curves("page.toml", to="b.h5", **tables)
    assert of_file.curves[0].values.tolist() == [6.0, 6.3]
    assert nv.response_curves(curves.request, to="c.h5").request.hash == curves.request.hash
    with nv.read("a.h5") as view:
        assert (view["status"] == OK).all()


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("panel = 1", "panel = 3", "panel = 3"),
        ("panels", "figure = { reduction = true }\npanels", "reduction = true needs one panel"),
        ("record", 'start = { policy = "random", count = 2 }\nrecord', "begins 2 orbits"),
        ('color = "blue"', 'color = "blu"', "did you mean 'blue'"),
    ],
)
def test_a_wrong_file_is_one_line(here, refusal, old, new, words):
    (here / "page.toml").write_text(PAGE.replace(old, new, 1))
    assert words in refusal("response-curves", "page.toml", "--dry-run")


def test_a_dry_run_says_what_would_be_done(here, answer):
    text = answer("response-curves", "page.toml", "--plot", "a.png", "--dry-run")
    assert text.count("curve: ") == 3
    assert "100 + 10 each, 1650 in all" in text
    assert "page.h5" in text
    assert sorted(path.name for path in here.iterdir()) == ["page.toml"]


@pytest.mark.kernels
def test_a_frame_without_dampers_has_its_energy_and_displacements_in_closed_form(tmp_path):
    frame = nv.shear_frame([1e4] * 3, [8e6] * 3, ratio=0.02)
    cells = [
        nv.Damper(name, "roof", m=300.0, k=500.0, c=60.0, walls=[nv.Wall(0.01, K=3e7)])
        for name in "ab"
    ]
    drive = {"force": {"roof": 1500.0, "floor1": 300.0}, "omega": 12.6}
    systems = [nv.System.from_host(frame, cells[:count], **drive, name="ab") for count in (1, 2)]
    show = ["E1max", "roof.x_max", "roof-floor2.a_max"]
    request = {"vary": {"omega": [12.0, 12.6, 35.0]}, "figure": {"show": show}}
    curves = nv.response_curves(systems, to=tmp_path / "a.h5", quiet=True, **request)
    alone, *damped = curves.curves
    for i, (omega, energy) in enumerate(zip(alone.values, alone.E1max, strict=True)):
        X = frame.frequency_response(omega, force=drive["force"])
        assert alone["roof.x_max"][i] == pytest.approx(abs(X[2]), rel=1e-9)
        assert alone["roof-floor2.a_max"][i] == pytest.approx(omega**2 * abs(X[2] - X[1]), rel=1e-9)
        mean = omega**2 * (X.conj() @ frame.M @ X) + X.conj() @ frame.K @ X
        swing = X @ frame.K @ X - omega**2 * (X @ frame.M @ X)
        assert energy == pytest.approx((mean.real + abs(swing)) / 4, rel=1e-9)
    for curve in damped:
        np.testing.assert_array_equal(curve["reduction"], 1.0 - curve.E1max / alone.E1max)
        assert curve.peak_reduction == 1.0 - curve.peak / alone.peak
    assert np.isnan(damped[0]["b.E2max"]).all()
    of = ["roof", "roof-floor2"]
    sampling = {"periods": 240, "transient": 600, "of": of, "quiet": True}
    for system, curve in zip(systems, damped, strict=True):
        orbit = nv.simulate(system, record=["energy", "response"], **sampling)
        for damper, energy in zip(system.dampers, orbit.E2max, strict=True):
            assert curve[f"{damper.name}.E2max"][1] == energy > 0.0
        assert curve["roof.x_max"][1] == orbit.response["roof.x_max"]
        assert curve["roof-floor2.a_max"][1] == orbit.response["roof-floor2.a_max"]
    labels = [axes.get_ylabel() for axes in nv.plot(tmp_path / "a.h5").axes]
    assert labels[1:3] == [
        "largest displacement, roof [m]", "largest absolute acceleration, roof-floor2 [m/s$^{2}$]"
    ]  # fmt: skip


@pytest.mark.kernels
def test_impulses_at_rigid_walls_are_those_of_each_damper(tmp_path):
    """Of hosts with one damper and with two; energies beside a kind, whose damper has no name."""
    frame = nv.shear_frame([1e4] * 3, [8e6] * 3, ratio=0.02)
    rigid = [nv.Wall(0.01, side, law="restitution", e=0.6) for side in "+-"]
    ball = nv.Damper("ball", "roof", m=300.0, walls=rigid)
    soft = nv.Damper("soft", "roof", m=300.0, k=500.0, walls=[nv.Wall(0.001, K=3e7)])
    drive = {"force": {"roof": 1500.0}, "omega": 12.6}
    one, two = (nv.System.from_host(frame, it, **drive) for it in ([ball], [ball, soft]))
    span = {"periods": 30, "transient": 40}

    def curves(systems, shown):
        tables = {"figure": {"show": [shown]}, "vary": {"omega": [12.0, 12.6]}, "sampling": span}
        path = tmp_path / f"{len(systems)}.h5"
        return nv.response_curves(systems, to=path, quiet=True, **tables).curves

    expected = []
    for system in (one, two):
        orbit = nv.simulate(system, 30, transient=40, record=["response", "impacts"], quiet=True)
        expected.append(orbit.response["ball.impulse_max"])
        assert orbit.impacts["impulse"][orbit.impacts["damper"] == "ball"].max() == expected[-1]
    _, single = curves([one], "impulse_max")
    assert single["impulse_max"][1] == expected[0]
    _, single, both = curves([one, two], "ball.impulse_max")
    assert [single["ball.impulse_max"][1], both["ball.impulse_max"][1]] == expected
    assert np.isnan([single["soft.impulse_max"], both["soft.impulse_max"]]).all()
    (axes,) = (axes for axes in nv.plot(tmp_path / "2.h5").axes if "impulse" in axes.get_ylabel())
    assert axes.get_ylabel() == "largest impulse, ball [N s]"
    kind = nv.load_system("ssul-set6", law="restitution", e=0.7)
    of_kind, both, single = curves([kind, two, one], "E2max")[2:]
    how = {"transient": 40, "record": ["energy"], "quiet": True}
    assert of_kind["E2max"][1] == nv.simulate(kind, 30, omega=12.6, **how).E2max
    assert [single["E2max"][1]] == nv.simulate(one, 30, **how).E2max
    assert np.isnan(both["E2max"]).all()


@pytest.mark.kernels
def test_curves_of_kinds_beside_hosts_have_their_own_responses(tmp_path, error_of):
    """The archive gives its request again; a curve lacks what its system has not."""
    frame = nv.shear_frame([1e4] * 2, [8e6] * 2, ratio=0.02)
    cell = nv.Damper("a", "roof", m=300.0, k=2e4, c=150.0, walls=[nv.Wall(0.01, K=3e6)])
    ball = nv.Damper("b", "roof", m=200.0, k=1e4, walls=[nv.Wall(0.01, law="restitution", e=0.5)])
    drive = {"force": {"roof": 1500.0}, "omega": 12.0}
    one, two = (nv.System.from_host(frame, it, **drive) for it in ([cell], [cell, ball]))
    kind, oscillator = "ssul-set6", nv.load_system("impact-oscillator")
    tables = {
        "vary": {"omega": {"values": [6.0, 7.0]}},
        "sampling": {"transient": 20, "periods": 10},
        "quiet": True,
    }
    roof = nv.simulate(
        one.with_(omega=7.0), 10, transient=20, record=["response"], of=["roof"], quiet=True
    )
    for number, (systems, asked) in enumerate([
        ([kind, one], {"record": {"want": ["energy", "response"]}}),
        ([kind, one], {"record": {"want": ["energy", "response"], "of": ["roof"]}}),
        ([one, kind, oscillator], {"figure": {"show": ["roof.x_max", "x1_max"]}}),
        ([kind, two], {"figure": {"show": ["roof.x_max", "b.impulse_max"]}}),
        ([kind, two], {"figure": {"show": ["a-b.x_max"]}}),  # of no structure alone
    ]):  # fmt: skip
        path = tmp_path / f"{number}.h5"
        made = nv.response_curves(systems, to=path, **asked, **tables)
        read = nv.open_archive(path)
        assert read.request.document() == made.request.document()
        assert read.request.hash == made.request.hash
        for before, after in zip(made.curves, read.curves, strict=True):
            assert before.name == after.name
            assert before.numbers.keys() == after.numbers.keys()
            for name, values in before.numbers.items():
                np.testing.assert_array_equal(after.numbers[name], values)
        by_name = {curve.case.scan.system.kind: curve for curve in read.curves}
        assert np.isnan(by_name["host"]["x1_max"]).all()
        assert np.isfinite(by_name["ssul"]["x1_max"]).all()
        if one in systems:
            assert by_name["host"]["roof.x_max"][1] == roof.response["roof.x_max"]
            assert np.isnan(by_name["ssul"]["roof.x_max"]).all()
    record = {"want": ["energy", "response"], "of": ["attic"]}
    text = error_of(nv.response_curves, [kind, one], record=record, **tables)
    assert "[[curves]] 2" in text
    assert "unknown displacement 'attic'; allowed: floor1, roof, a" in text
    assert "names no displacements" in error_of(nv.response_curves, kind, record=record, **tables)


def test_displacements_of_hosts_are_named_or_refused(error_of):
    frame = nv.shear_frame([1e4] * 2, [8e6] * 2)
    cell, other = (nv.Damper("a", place, m=300.0, k=5e4) for place in frame.dofs)
    one, two = (
        nv.System.from_host(frame, [it], force={"roof": 1.0}, omega=9.0) for it in (cell, other)
    )

    def error(systems, *show, **record):
        tables = {"figure": {"show": show}, "record": record}
        return error_of(nv.response_curves, systems, vary={"omega": [9.0]}, **tables)

    assert "no curve has it; allowed: E1max, E2max, roof.x_max, roof.x_rms" in error([two], "x_max")
    assert "unknown displacement 'attic'; allowed: floor1, roof, a" in error([one], "attic.x_max")
    assert "no curve has it" in error([one], "roof.x_max", of=["floor1"])
    assert "of floor1 and of roof" in error([one, two], "E1max", want=["response"])
    assert "unknown show 'roof.xmax'; allowed: E1max" in error([one], "roof.xmax")
