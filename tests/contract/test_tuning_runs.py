"""A search gives the same bits again, survives an interrupt, and logs all that it looked at."""

import numpy as np
import pytest
from made_up import content
from scipy.spatial.distance import pdist

import nlds_vines as nv
from nlds_vines.tuning import picture as drawn
from nlds_vines.tuning.command import main
from nlds_vines.tuning.result import STAGES
from nlds_vines.tuning.run import Objective

pytestmark = pytest.mark.kernels

SMALL = ["--population", "8", "--generations", "5", "--polish", "12", "--optima", "2"]
TMD = ["--system", "tmd", *SMALL, "--band", "5.5:7:4", "--surface", "k2,c2", "--surface-size", "3"]
SSUL = ["--transient", "40", "--periods", "20", "--free", "k2=100:1500", *SMALL]


def tune(path, *arguments):
    """Run the command quietly and return what its archive holds, to the last bit."""
    assert main([*arguments, "-o", str(path), "--quiet"]) == 0
    return content(path)


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """Return the archive of a search that nothing has disturbed."""
    path = tmp_path_factory.mktemp("whole") / "a.h5"
    tune(path, *TMD)
    return path


@pytest.fixture
def interrupt(monkeypatch):
    """Return a function that lets the next search be interrupted at its n-th batch."""
    real, calls = Objective.results, []

    def after(most):
        calls.clear()

        def results(self, trials):
            if len(calls) == most:
                raise KeyboardInterrupt
            calls.append(len(trials))
            return real(self, trials)

        monkeypatch.setattr(Objective, "results", results)
        return calls

    return after


@pytest.mark.parametrize("arguments", [TMD, SSUL], ids=["tmd", "ssul"])
def test_threads_do_not_matter_and_seeds_do(arguments, tmp_path):
    first = tune(tmp_path / "a.h5", *arguments, "--threads", "1")
    assert tune(tmp_path / "b.h5", *arguments, "--threads", "2") == first
    other = tune(tmp_path / "c.h5", *arguments, "--seed", "1")
    assert other["k2"] != first["k2"]


def test_a_peak_is_judged_between_the_values_of_its_band(tmp_path, whole):
    """With eight times the steps it is that of a scan of the best design over these values."""
    band = [*TMD[:-4], "--band", "5.5:7:7"]
    assert main([*band, "-o", str(tmp_path / "a.h5"), "--quiet"]) == 0
    tuned = nv.open_archive(tmp_path / "a.h5")
    best, text = tuned.best, "\n".join(tuned.lines())
    how = {"transient": tuned.request.transient, "periods": tuned.request.periods}
    finer = {"omega": {"start": 5.5, "stop": 7.0, "num": 49}}
    system = nv.load_system("tmd", **best.parameters)
    scan = nv.scan(system, vary=finer, sampling=how, record=["energy"], quiet=True)
    E1max = scan.read()["E1max"][:, 0]
    assert best.objective == pytest.approx(E1max[::8].max(), rel=1e-9)
    assert best.finer == pytest.approx(E1max.max(), rel=1e-9)
    assert best.finer > best.objective
    assert "E1max is the largest of 7 values of omega; finer: of 49" in text
    assert f"{best.objective:11.5g}  {best.finer:11.5g}" in text
    assert "optimum_finer" not in content(whole)  # four values are no band
    assert np.isnan(nv.open_archive(whole).best.finer)


@pytest.mark.parametrize("batches", [0, 4, 22])
def test_an_interrupted_search_resumes_to_the_same_bits(batches, tmp_path, whole, interrupt, ask):
    path = tmp_path / "b.h5"
    interrupt(batches)
    printed = ask("tuning", *TMD, "-o", path, "--quiet", status=130).err
    assert "--resume" in printed
    assert printed.count("\n") == 1
    assert not path.exists()
    if batches:  # blocks are kept: not without saying what to do
        assert main([*TMD, "-o", str(path), "--quiet"]) == 2
    calls = interrupt(None)
    assert tune(path, *TMD, "--resume") == content(whole)
    with nv.read(path) as view:
        done = view.attrs["replayed"]
        assert sum(calls) == view["objective"].size - done
    assert (done > 0) == (batches > 0)
    assert not list(tmp_path.glob("*.blocks"))


def test_every_evaluation_is_logged_with_what_it_found(tmp_path, interrupt):
    calls = interrupt(None)
    tune(tmp_path / "a.h5", *TMD, "--seeds", "2")
    with nv.read(tmp_path / "a.h5") as view:
        arrays = {name: view[name] for name in view.names}
        assert view.flags("stage") == {code: name for name, code in STAGES.items()}
        assert view["search"].tolist() == [0, 1]
    assert sum(calls) == arrays["objective"].size
    assert set(arrays["stage"]) == set(STAGES.values())
    assert np.count_nonzero(arrays["stage"] == STAGES["surface"]) == 9
    for i in (0, 17, arrays["objective"].size - 1):
        omega = arrays["case_omega"][arrays["worst_case"][i]]
        system = nv.load_system("tmd", k2=arrays["k2"][i], c2=arrays["c2"][i], omega=omega)
        orbit = nv.simulate(system, 2, transient=300, record=("section", "energy"))
        assert orbit.E1max == arrays["objective"][i]


def test_the_result_is_what_the_archive_says(tmp_path):
    search = {"population": 8, "generations": 5, "polish": 12, "seeds": 3}
    tuned = nv.tune("tmd", tmp_path / "a.h5", search=search, over={"P": {"values": [600, 900]}})
    with nv.read(tuned.path) as view:
        searched = view["stage"] <= STAGES["polish"]
        assert tuned.objective == view["objective"][searched].min()
        assert tuned.evaluations == searched.size
        request = view.attrs["scan"]
        assert view.attrs["seed"] == 0
    assert tuned.objective == min(tuned.spread.values())
    assert tuned.optima[0].robustness["none"] == tuned.objective
    assert tuned.best.worst == max(tuned.best.robustness.values()) >= tuned.objective
    assert tuned.best.robustness[tuned.best.cause] == tuned.best.worst
    assert any(line.startswith("3 seeds: best") for line in tuned.lines())
    (tmp_path / "again.toml").write_text(request)  # what is stored repeats it
    assert tune(tmp_path / "b.h5", str(tmp_path / "again.toml")) == content(tuned.path)


def test_what_is_free_has_no_value_among_the_attributes_and_no_surface_is_drawn(here, answer):
    """A parameter that does nothing is called so."""
    text = answer("tuning", *SSUL, "--free", "E2", "--free", "V", "-o", "a.h5")
    assert "V does not enter the dynamics" in text
    with nv.read("a.h5") as view:
        assert not {"k2", "c2", "C", "E2", "K", "V"} & view.attrs.keys()
        assert view.attrs["m2"] == 60.0
        assert set(view["optimum_E2"] > 0) == {True}
    # without a surface the picture has the designs of the search
    with nv.read("a.h5") as view:
        axes = drawn.tuning_picture(view).axes[0]
        searched = np.isin(view["stage"], [STAGES["global"], STAGES["polish"]])
    dots = sum(len(one.get_offsets()) for one in axes.collections)
    assert dots == np.count_nonzero(searched)


def test_the_surface_shows_parameters_values_and_optima_alike_every_time(whole, tmp_path):
    for form in ("png", "svg"):
        pictures = [tmp_path / f"{name}.{form}" for name in "ab"]
        for picture in pictures:
            drawn.PICTURE.save(whole, picture)
        assert pictures[0].read_bytes() == pictures[1].read_bytes()
    with nv.read(whole) as view:
        axes, bar = drawn.tuning_picture(view).axes
        (mesh,) = (one for one in axes.collections if np.size(one.get_array()) == 9)
        assert mesh.get_array().ravel().tolist() == view["surface"].T.ravel().tolist()
        assert "k_2$ [N/m]" in axes.get_xlabel()
        assert "c_2$ [N s/m]" in axes.get_ylabel()
        assert "[J]" in bar.get_ylabel()
        star = axes.lines[0].get_xydata()[0].tolist()
        assert star == [view["optimum_k2"][0], view["optimum_c2"][0]]
    assert axes.get_xscale() == axes.get_yscale() == "log"


def test_a_tuning_of_one_parameter_is_a_curve_through_all_designs(tmp_path):
    path = tmp_path / "a.h5"
    tune(path, "--system", "tmd", "--set", "c2=112", "--plot", str(tmp_path / "a.png"), *SMALL)
    assert (tmp_path / "a.png").stat().st_size > 0
    with nv.read(path) as view:
        assert "surface" not in view
        (axes,) = drawn.tuning_picture(view).axes
        optimum = [view["optimum_k2"][0], view["optimum_objective"][0]]
    curve, star = axes.get_lines()
    assert star.get_xydata()[0].tolist() == optimum
    assert curve.get_ydata().min() == optimum[1]
    assert len(curve.get_xdata()) > 20
    assert (np.diff(curve.get_xdata()) >= 0).all()
    assert axes.get_xlabel().endswith("$k_2$ [N/m]")


def test_contours_have_values_that_hide_neither_each_other_nor_the_optimum(tmp_path):
    path = tmp_path / "a.h5"
    tune(path, "--system", "tmd", "--surface", "k2,c2", "--surface-size", "15", *SMALL)
    with nv.read(path) as view:
        figure = drawn.tuning_picture(view)
        best = [view["optimum_k2"][0], view["optimum_c2"][0]]
    axes = figure.axes[0]
    values = [text.get_position() for text in axes.texts if text.get_text().endswith(" J")]
    assert len(values) >= 2
    assert pdist(axes.transData.transform([best, *values])).min() >= 0.3 * figure.dpi


def test_xarray_and_what_looks_after_scans_know_a_tuning(tmp_path, whole, answer):
    assert "results are the same" in answer("rerun", whole, "-o", tmp_path / "again.h5")
    xarray = pytest.importorskip("xarray")
    with xarray.open_dataset(whole, engine="h5netcdf") as data:
        assert data["surface"].dims == ("surface_k2", "surface_c2")
        assert data["objective"].dims == ("evaluation",)
        assert data["robustness"].sel(optimum=0).size == 4 + 4 + 4
