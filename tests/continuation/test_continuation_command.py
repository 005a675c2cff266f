"""The command: archives that survive, pictures, borders, curves, branches beside slow sweeps."""

import numpy as np
import pytest
import xarray
from layout import collisions
from test_closed_forms import located

import nlds_vines as nv
from nlds_vines import continue_branch, load_continuation, load_system, read, simulate
from nlds_vines.__main__ import main
from nlds_vines.continuation import run as running
from nlds_vines.continuation.picture import branch_diagram, picture
from nlds_vines.continuation.regime_borders import borders_of
from nlds_vines.continuation.result import read_continuation
from nlds_vines.loads.picture import envelope
from paper.linear import response

pytestmark = pytest.mark.kernels


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("branches")


@pytest.fixture(scope="module")
def archive(folder):
    """Return the archive of a continuation of Set 6, T,1 and 2T."""
    path = folder / "branches.h5"
    quick = "continuation --along omega=7.3:7.8 --doublings 1 --unstable 30 --quiet"
    assert main([*quick.split(), "-o", str(path)]) == 0
    return path


@pytest.fixture(scope="module")
def scan(folder):
    """Return the archive of a scan over the same frequencies."""
    path = folder / "scan.h5"
    scanned = "bifurcation --vary omega=7.35:7.8:46 --record section,energy,regime --quiet"
    assert main([*scanned.split(), "-o", str(path)]) == 0
    return path


def test_an_archive_opens_elsewhere_repeats_itself_and_is_what_python_returns(
    archive, tmp_path, answer, refusal
):
    with xarray.open_dataset(archive, engine="h5netcdf") as data:
        assert data.attrs["content"] == "continuation"
        assert set(data["kind"].dims) == {"special"}
        assert data["omega"].dims == ("point",)
        assert data["multipliers"].attrs["units"] == "1"
    rerun = ["rerun", archive, "-o", tmp_path / "again.h5"]
    assert "results are the same" in answer(*rerun)
    refusal(*rerun, "--shard", "1/2")
    path = read_continuation(archive)
    request = load_continuation(path.request.document())
    assert request == path.request
    again = running.compute(request)
    for name, values in path.tables.items():
        assert np.array_equal(values, again[name], equal_nan=values.dtype.kind == "f"), name


def test_python_takes_a_request_and_its_file_and_overrides_them(tmp_path, error_of):
    file, bounds = tmp_path / "branch.toml", (7.3, 7.4)
    along = "[along]\nomega = { start = 7.3, stop = 7.4 }"
    file.write_text(f'system = "ssul-set6"\n{along}\n[search]\nunstable = 9\n')
    whole = continue_branch(load_continuation(file))
    named = continue_branch("ssul-set6", "omega", bounds, unstable=9)
    for again in (continue_branch(file), named):
        assert np.array_equal(again.branches[0].states, whole.branches[0].states)
    other = continue_branch(file, "omega", (7.3, 7.32), step=0.1).request.document()
    assert other["along"]["omega"]["stop"] == 7.32
    assert (other["search"]["step"], other["search"]["unstable"]) == (0.1, 9)
    for wrong in ({"parameter": "omega"}, {"bounds": bounds}):
        assert "parameter and bounds belong together" in error_of(continue_branch, file, **wrong)


def test_the_legend_of_the_diagram_stands_clear_of_title_and_panels(archive):
    figure = branch_diagram(read_continuation(archive))
    figure.draw_without_rendering()
    (legend,) = (legends for axes in figure.axes if (legends := axes.get_legend()))
    (title,) = figure.texts
    words = [text.get_window_extent() for text in legend.get_texts()]
    assert len(words) > 5  # more than a line of them
    assert title.get_window_extent().y0 > max(axes.get_tightbbox().y1 for axes in figure.axes)
    legend.set_in_layout(False)
    assert max(box.y1 for box in words) < min(axes.get_tightbbox().y0 for axes in figure.axes)
    assert collisions(figure) == []


def test_branches_over_a_scan_explain_its_borders(archive, scan, folder, answer):
    path, plot = folder / "over.h5", folder / "over.png"
    along = ["--along", "omega=7.3:7.8", "--unstable", "40", "--from", scan, "--over", scan]
    text = answer("continuation", *along, "--plot", plot, "-o", path)
    assert "borders between regimes" in text
    assert plot.stat().st_size > 20_000
    branches = read_continuation(path)
    with read(scan) as view:
        borders = borders_of(branches, view)
    assert borders
    assert all(border.is_explained for border in borders if any(border.periodic))
    first = borders[0]
    assert (first.before, first.events[0][0]) == ("T,1", "PD")
    assert first.events[0][1] == pytest.approx(7.362158433, abs=1e-8)


def test_curves_in_a_plane(folder, scan, error_of):
    """The curve of grazing is that of the linear response; PD and LP meet it nowhere else."""
    path, plot = folder / "plane.h5", folder / "plane.svg"
    along = ["continuation", "--along", "omega=7:8", "--plane", "P=700:900", "--quiet"]
    assert main([*along, "-o", str(path), "--plot", str(plot)]) == 0
    branches = read_continuation(path)
    (grazing,) = [curve for curve in branches.curves if curve.kind == "GR"]
    assert len(grazing.values) > 10
    for omega, P in grazing.values[:: len(grazing.values) // 8]:
        there = load_system("ssul-set6", omega=omega, P=P)
        amplitude = float(response(there, np.array(omega)).shortening)
        assert amplitude == pytest.approx(there.parameters["C"], rel=1e-9)
    doubling = next(curve for curve in branches.curves if curve.kind == "PD")
    assert np.abs(np.abs(doubling.multipliers + 1.0).min(axis=1)).max() < 1e-7
    assert plot.stat().st_size > 10_000
    # the same curves over a map of regimes, whichever of its parameters comes first
    regimes, over = folder / "map.h5", folder / "map.png"
    scanned = "bifurcation --vary P=700:900:5 --vary omega=7:8:11 --record regime --quiet"
    assert main([*scanned.split(), "-o", str(regimes)]) == 0
    picture(regimes).save(path, over)
    assert over.stat().st_size > plot.stat().st_size // 4
    assert "varies omega, not" in error_of(picture(scan).save, path, over)


def test_states_on_a_curve_are_orbits_where_the_rest_position_moves():
    """V shifts x2 alone: along a curve in (omega, V), each state is an orbit of its own system."""
    path = continue_branch("ssul-set6", "omega", (7.2, 7.6), plane=("V", 0.05, 0.2))
    curve = next(curve for curve in path.curves if curve.kind == "PD")
    assert curve.ends == ("bound", "bound")
    off = np.abs(curve.values[[0, -1]][:, [0, 0, 1, 1]] - [7.2, 7.6, 0.05, 0.2])
    assert (off.min(axis=1) < 1e-15).all()  # the curve ends on bounds, not beyond
    for i in (1, len(curve.values) // 2, -2):
        omega, V = curve.values[i]
        there = load_system("ssul-set6", omega=omega, V=V)
        end = simulate(there, 1, start=curve.states[i], tolerance="fine").state
        assert np.allclose(end, curve.states[i], rtol=0, atol=1e-9)


DAMPER, P, PERIODS = "ssul-set5", 800.0, 20
RATES = 2e-4, 5e-5  # rad/s^2


@pytest.fixture(scope="module")
def folding(tmp_path_factory):
    """Return the branches of a damper along omega, with their archive."""
    path = tmp_path_factory.mktemp("folding") / "folding.h5"
    return nv.continue_branch(DAMPER, "omega", (6.9, 7.4), to=path, quiet=True)


def jump(first, last, rate):
    """Return the frequency of a sweep at which E1 changes most, by means over periods beside it."""
    length = abs(last - first) / rate
    sweep = {"amplitude": P, "first": first, "last": last, "length": length}
    amplitudes = nv.response_history(
        DAMPER, load={"sweep": sweep}, duration=length, sampling={"samples": 32}, quiet=True
    )
    (sweep,), (fall,) = amplitudes.request.load.sweep, amplitudes.results.values()
    omega, energy = envelope(sweep, fall.time, fall.E1, 2 * np.pi / np.sqrt(40.0))
    means = np.convolve(energy, np.ones(PERIODS) / PERIODS, mode="valid")
    change = np.abs(means[PERIODS:] - means[:-PERIODS])
    places = omega[PERIODS : PERIODS + len(change)]
    inside = (places > 7.02) & (places < 7.27)
    return places[inside][change[inside].argmax()]


def test_a_slow_sweep_jumps_behind_the_fold_and_nearer_to_it_the_slower_it_is(folding):
    """The delay of a slow passage through a fold grows with its rate to the power 2/3."""
    folds = located(folding, "LP").value
    upper, lower = folds.max(), folds.min()
    delays = [jump(6.95, 7.3, rate) - upper for rate in RATES]
    assert 0 < delays[1] < delays[0] < 0.02
    assert delays[0] / delays[1] == pytest.approx(4 ** (2 / 3), rel=0.06)
    exact = (4 ** (2 / 3) * delays[1] - delays[0]) / (4 ** (2 / 3) - 1)
    assert exact == pytest.approx(0, abs=4e-4)
    delays = [lower - jump(7.3, 6.95, rate) for rate in RATES]
    assert 0 < delays[1] < delays[0] < 0.01


def test_branches_are_drawn_beside_a_sweep(folding, tmp_path, refusal, ask):
    path, picture = tmp_path / "sweep.h5", tmp_path / "sweep.png"
    load = f"sweep:amplitude={P:g},first=7.0,last=7.3,length=60"
    asked = f"response-history --system {DAMPER} --load {load} --duration 60 --quiet"
    ask(*asked.split(), "-o", path)
    figure = nv.plot(path, "sweep_energy", marks=folding.path)
    (axes,) = figure.axes
    branch = folding.branches[0]
    drawn = [line for line in axes.get_lines() if len(line.get_xdata()) == len(branch)]
    assert all(np.array_equal(line.get_xdata(), branch.parameter) for line in drawn)
    assert np.array_equal(drawn[0].get_ydata(), branch.E1max)
    assert np.array_equal(np.isfinite(drawn[1].get_ydata()), branch.stable)
    assert axes.get_xlim() == (7.0, 7.3)
    plot = ["plot", path, "-o", picture, "--mark"]
    assert "--show sweep_energy" in refusal(*plot, folding.path)
    other = nv.continue_branch(
        load_system(DAMPER, P=700.0), "omega", (7.2, 7.3), to=tmp_path / "other.h5", quiet=True
    )
    assert "P = 700.0, not 800.0" in refusal(*plot, other.path, "--show", "sweep_energy")
    assert not picture.exists()
