"""Tables of samples: sets of parameters in place of axes, from arrays, frames and CSV files."""

import os

import numpy as np
import pytest
from configurations import USUAL

import nlds_vines as nv
from nlds_vines import load_scan, read
from nlds_vines.bifurcation.blocks import blocks_of
from nlds_vines.bifurcation.picture.drawing import PICTURE
from nlds_vines.model.axis import samples_of

SAMPLING = {"transient": 8, "periods": 6, "effort": "quick"}
VARIED = {
    "k1": [4.0e4, 4.2e4, 3.8e4, 4.0e4],
    "zeta2": [0.02, 0.05, 0.03, 0.02],
    "f": [1.0, 1.1, 0.95, 1.05],
}
COLUMNS = {**VARIED, "x1_0": [0.0, 0.1, 0.0, -0.1]}


def scan_of(columns=COLUMNS, **changes):
    document = {"system": "ssul-set6", "samples": columns, "sampling": SAMPLING}
    return load_scan({**document, "record": {"want": list(USUAL)}, **changes})


def written(path, text):
    path.write_text(text)
    return path


def test_the_archive_has_the_table_gives_back_each_orbit_and_does_not_depend_on_blocks(
    tmp_path, monkeypatch
):
    scan = nv.scan(
        "ssul-set6", samples=COLUMNS, record=list(USUAL), sampling=SAMPLING, quiet=True,
        to=tmp_path / "draws.h5",
    )  # fmt: skip
    with scan.read() as view:
        assert view.axes == ("sample",)
        assert view["sample"].tolist() == [1, 2, 3, 4]
        for name, values in COLUMNS.items():
            assert view[name].tolist() == values
            assert view.dims(name) == ("sample",)
        assert view.units("f") == "Hz"
        view.to_csv(tmp_path / "draws.csv")
        head = (tmp_path / "draws.csv").read_text().partition("\n")[0]
        assert head.startswith(f"sample,start,{','.join(sorted(COLUMNS))},")
        sections, energies = view["section"], view["E1max"]
    # each sample is the orbit of its own parameters
    for i, (start, *row) in enumerate(zip(COLUMNS["x1_0"], *VARIED.values(), strict=True)):
        system = nv.load_system("ssul-set6", **dict(zip(VARIED, row, strict=True)))
        state = start, 0.0, system.rest, 0.0
        orbit = nv.simulate(system, 6, transient=8, start=state, quiet=True)
        assert np.array_equal(orbit.section, sections[i, 0])
    orbit = nv.orbit_of(scan, sample=3, quiet=True)
    assert np.array_equal(orbit.section, sections[2, 0])
    assert orbit.system.ratios["f"] == pytest.approx(0.95)
    assert scan.request == scan_of(title=scan.request.title)
    # blocks and threads change nothing
    monkeypatch.setattr("nlds_vines.bifurcation.blocks.BLOCK_PERIODS", 14)
    assert len(blocks_of(scan_of())) == 4
    with nv.scan(scan_of(), quiet=True, threads=2).read() as parts:
        assert np.array_equal(parts["section"], sections)
        assert np.array_equal(parts["E1max"], energies)


def test_files_frames_and_arrays_mean_the_same(tmp_path):
    class Frame:
        columns = ("k1", "C")

        def __getitem__(self, name):
            return {"k1": [4e4, 5e4], "C": [0.05, 0.0625]}[name]

    comma = written(tmp_path / "a.csv", "# drawn by hand\nk1,C\n4e4,0.05\n5e4,0.0625\n\n")
    semicolon = written(tmp_path / "b.csv", "\ufeffk1; C\n40000;0,05\n50000;0,0625\n")
    tabs = written(tmp_path / "c.csv", "k1\tC\n4e4\t0.05\n5e4\t0.0625\n")
    usual = samples_of({"k1": np.array([40000, 50000]), "C": [0.05, 0.0625]})
    for source in (Frame(), comma, str(semicolon), {"file": str(tabs)}, usual):
        assert samples_of(source) == usual
    assert hash(samples_of(comma)) == hash(usual)


@pytest.mark.parametrize(
    ("source", "words"),
    [
        ({}, "no column"),
        ({"k1": []}, "0 rows"),
        ({"k1": [1.0, 2.0], "C": [1.0]}, "different lengths: k1 2, C 1"),
        ({"k1": [4e4, float("nan")]}, "row 2: k1 = nan must be a finite number"),
        ({"k1": [4e4, np.inf]}, "row 2: k1 = inf"),
        ({"k1": [4e4, "much"]}, "row 2: k1 = 'much' must be a number"),
        ({"k1": ["4e4", 5e4]}, "row 1: k1 = '4e4' must be a number"),
        ({"k1": [True, False]}, "row 1: k1 = True must be a number"),
        ({"k1": 4e4}, "k1 must be a list of numbers"),
        ({"k1": [[4e4], [5e4]]}, "k1 must be a list of numbers"),
        ({3: [4e4]}, "column 3 must be named"),
        ({"k1": np.ma.array([4e4, 5e4], mask=[False, True])}, "k1 has masked entries"),
        (5, "must be arrays by name, a DataFrame or the path of a CSV file"),
        ("", "t.csv': the file is empty"),
        ("k1,C\n", "0 rows"),
        ("k1,C\n4e4\n", "line 2 has 1 cells, the heading 2"),
        ("k1,C\n4e4,\n", "line 2: C = '' must be a number"),
        ("# a\nk1,C\n4e4,0.05\n5e4,x\n", "line 4: C = 'x' must be a number"),
        ("k1\n4_0000\n", "line 2: k1 = '4_0000' must be a number in the digits 0 to 9"),
        ("k1\n\u0664\n", "line 2: k1 = '\u0664' must be a number in the digits 0 to 9"),
        ("k1\n" + "4" * 200_000, "is no table of comma-separated values: field larger than"),
        ("," * 99_999 + "k1\n" + "1\n" * 99_999, "column 1 has no name"),
        ("a" + ",a" * 99_999 + "\n" + "1\n" * 99_999, "column 'a' occurs twice"),
        ("k1,C\n4e4,nan\n", "row 1: C = nan must be a finite number"),
        (",k1\n0,4e4\n", "to_csv(..., index=False)"),
        ("k1,k1\n4e4,4e4\n", "column 'k1' occurs twice"),
    ],
)
def test_faulty_tables_and_files_are_refused(source, words, here, error_of):
    is_file = isinstance(source, str)
    line = error_of(samples_of, written(here / "t.csv", source) if is_file else source)
    assert words in line
    assert ("t.csv" in line) == is_file


def test_a_pipe_in_place_of_a_table_is_refused_at_once(here, error_of):
    os.mkfifo("t.csv")
    assert "cannot be read: it is no regular file" in error_of(samples_of, "t.csv")


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"samples": {"kk1": [4e4]}}, "unknown column 'kk1'; allowed: m1, k1"),
        ({"samples": {"k1": [4e4, -1.0]}}, "k1 = -1.0"),
        ({"samples": {"k2": [1.0], "c2": [1.0], "zeta2": [0.1]}}, "c2 beside zeta2"),
        ({"samples": {"phase": [0.1]}, "start": {"policy": "up"}}, "phase is varied"),
        ({"samples": {"k1": [4e4]}, "start": {"policy": "up"}}, "a sweep follows attractors"),
        ({"record": {"want": ["attractor"]}}, "samples have no order"),
        ({"set": {"k1": 4e4}}, "k1 is varied by"),
        ({"vary": {"omega": {"values": [5.0]}}}, "beside [vary]: give one of them"),
        ({"samples": {"file": "nowhere.csv"}}, "nowhere.csv': cannot be read: No such file"),
    ],
)
def test_tables_that_do_not_fit_are_refused(changes, words, error_of):
    assert words in error_of(scan_of, **changes)


def test_masked_axes_are_refused(error_of):
    masked = np.ma.array([5.0, 6.0], mask=[False, True])
    for entry in (masked, {"values": masked}):
        words = error_of(load_scan, "tmd", {"vary": {"omega": entry}})
        assert "omega has masked entries, which have no value: fill them first" in words
    whole = np.ma.array([5.0, 6.0], mask=[False, False])
    assert load_scan("tmd", {"vary": {"omega": whole}}).axes[0].values.tolist() == [5.0, 6.0]


def test_options_replace_axes_and_samples_and_values_are_part_of_the_hash():
    other = {**COLUMNS, "k1": [4.0e4, 4.2e4, 3.8e4, 4.0e4 + 1e-9]}
    assert scan_of().hash == scan_of(title="another").hash != scan_of(other).hash
    axes = {"vary": {"omega": {"values": [5.0, 6.0]}}}
    assert load_scan("tmd", {"samples": {"k1": [4e4]}}).varied == ("k1",)
    assert load_scan(load_scan("tmd", axes), {"samples": {"k1": [4e4]}}).varied == ("k1",)
    assert load_scan(scan_of(), axes).varied == ("omega",)


def test_the_command_computes_and_draws_a_file(here, answer, refusal):
    written(here / "draws.csv", "k1,f\n4e4,1.0\n4.1e4,1.1\n3.9e4,1.05\n")
    words = ["bifurcation", "--system", "ssul-set6", "--samples", "draws.csv", "--transient", 8]
    words += ["--periods", 6, "--record", ",".join(USUAL), "-o", "s.h5"]
    plan = answer(*words, "--dry-run")
    assert "3 samples of k₁, f" in plan
    assert "sampled:  k1 = 39000 to 41000" in plan
    assert not (here / "s.h5").exists()
    assert "unknown show 'E1max:C'" in refusal(*words, "--plot", "s.png", "--show", "E1max:C")
    answer(*words, "--plot", "s.png", "--show", "E1max,E1max:k1")
    assert (here / "s.png").stat().st_size > 10_000
    answer(*words, "--resume")
    with read("s.h5") as view:
        panels = PICTURE.names(view)
        assert [*panels][:4] == ["E1max", "E1max:exceedance", "E1max:f", "E1max:k1"]
        assert "regimes" in panels
        axes = PICTURE.figure(view).axes
    assert len(axes) == 5
    share = axes[1].lines[0].get_ydata()
    assert share.tolist() == pytest.approx([1.0, 2 / 3, 1 / 3])
    along = np.concatenate([line.get_xdata() for line in axes[3].lines])
    assert sorted(along.tolist()) == [3.9e4, 4.0e4, 4.1e4]
