"""What an archive holds, to the last bit, for every reader; files that others have written so."""

import errno
import io
import json
import os
import sys
import time

import h5py
import numpy as np
import pytest
import xarray as xr
from made_up import MAP, PLAIN, arrays, content, cut, make_scan, results, write

import nlds_vines as nv
from nlds_vines.archives import archive, provenance
from nlds_vines.bifurcation.picture.drawing import PICTURE
from nlds_vines.cli.terminal import say
from nlds_vines.runs.executors import threads_in_use
from nlds_vines.scans.block import Block
from scans import written


@pytest.fixture
def path(here):
    return here / "scan.h5"


@pytest.mark.parametrize(
    ("vary", "want"), [(None, PLAIN), (MAP, PLAIN), *((None, [want]) for want in PLAIN)]
)
def test_round_trip_bit_by_bit_also_by_any_program_that_reads_hdf5(path, vary, want):
    """What was asked for is there, and nothing else."""
    scan = make_scan(want, vary=vary, start={"policy": "random", "count": 2, "seed": 3})
    write(path, scan)
    whole = results(scan, Block(0, tuple((0, size) for size in scan.shape)))
    bits = arrays(path)
    assert bits.keys() == whole.keys()
    for entry in scan.table.datasets.values():
        expected = whole[entry.name]
        if entry.dtype == "str":
            assert bits[entry.name].tolist() == expected.tolist()
        else:
            assert bits[entry.name].dtype == np.dtype(entry.dtype)
            assert bits[entry.name].tobytes() == expected.astype(entry.dtype).tobytes()
    # as MATLAB does: numbers, strings of fixed length, units and meaning beside them
    with h5py.File(path) as file:
        dims = {dim for entry in scan.table.datasets.values() for dim in entry.dims}
        assert set(file) == whole.keys() | dims
        for name, dataset in file.items():
            assert dataset.fletcher32, name
            assert dataset.chunks, name
            assert isinstance(dataset.attrs["units"], str)
            assert dataset.attrs["long_name"]
            if dataset.dtype.kind == "S":
                assert h5py.check_string_dtype(dataset.dtype).length == dataset.dtype.itemsize
        for name, values in bits.items():
            dims = [dim[0].name[1:] for dim in file[name].dims]
            assert dims == list(scan.table.datasets[name].dims)
            if values.dtype == object:
                assert [text.decode() for text in file[name][...].flat] == values.ravel().tolist()
            else:
                assert file[name][...].tobytes() == values.tobytes()


def test_arrays_do_not_depend_on_how_the_scan_was_cut(tmp_path):
    scan = make_scan(vary=MAP)
    columns = [Block(i, ((0, 13), (2 * i, 2 * i + 2))) for i in range(3)]
    whole = content(write(tmp_path / "whole.h5", scan, cut(scan, 13)))
    assert content(write(tmp_path / "rows.h5", scan, cut(scan, 3))) == whole
    assert content(write(tmp_path / "columns.h5", scan, columns)) == whole


@pytest.mark.parametrize("system", ["ssul-set6", "tmd", "none"])
def test_xarray_opens_it_with_dimensions_units_and_flags(path, system):
    want = PLAIN if system == "ssul-set6" else ("section", "energy", "regime")
    scan = make_scan(want=want, system=system, vary=MAP)
    write(path, scan)
    with xr.open_dataset(path, engine="h5netcdf") as dataset:
        assert dict(dataset.sizes) == scan.table.length
        assert dataset.attrs["title"] == "a test"
        assert dataset["omega"].attrs["units"] == "rad/s"
        np.testing.assert_array_equal(dataset["omega"], scan.axes[0].values)
        assert dataset["start"].values.tolist() == ["rest"]
        assert dataset["forcing_period"].values.tolist() == [1, 2, 3]
        for entry in scan.table.datasets.values():
            variable = dataset[entry.name]
            attributes = variable.attrs["units"], variable.attrs["long_name"]
            assert (variable.dims, *attributes) == (entry.dims, entry.units, entry.long_name)
        flags = dataset["regime"].attrs
        assert flags["flag_values"].dtype == np.int8
        assert len(flags["flag_values"]) == len(flags["flag_meanings"].split(" "))


@pytest.mark.long
def test_a_million_cells_in_one_archive_open_lazily(here):
    axes = {"omega": {"start": 5.0, "stop": 8.0}, "P": {"start": 600.0, "stop": 1000.0}}
    sampling = {"transient": 1, "periods": 1}
    began = time.perf_counter()
    nv.scan("none", vary={name: {**ends, "num": 1000} for name, ends in axes.items()},
            sampling=sampling, record=["section", "energy"], to="million.h5")  # fmt: skip
    computed = time.perf_counter()
    with xr.open_dataset("million.h5", engine="h5netcdf", chunks=None) as dataset:
        assert dataset.sizes["omega"] * dataset.sizes["P"] == 10**6
        row = dataset["E1max"].isel(omega=500, start=0).values
    assert np.isfinite(row).all()
    assert time.perf_counter() - computed < computed - began  # a row, not the whole archive


def test_attributes_tell_where_it_comes_from(path):
    scan = make_scan()
    write(path, scan)
    with archive.read(path) as view:
        attrs = view.attrs
    exact = {
        "scan": scan.to_toml(), "scan_hash": scan.hash, "schema": provenance.SCHEMA, "seed": 0,
        "threads": threads_in_use(), "numpy_version": np.__version__,
        "K": scan.system.K, **scan.system.parameters,
    }  # fmt: skip
    assert {name: attrs[name] for name in exact} == exact
    assert attrs["history"].endswith(" ".join(sys.argv))
    assert attrs["source"].startswith("nlds_vines ")
    assert isinstance(json.loads(attrs["argv"]), list)
    assert attrs["seconds"] >= 0
    assert attrs.get("commit", "") == provenance.commit()
    assumed = {f"assumption_{name}" for name in scan.system.assumptions}
    assert {name for name in attrs if name.startswith("assumption_")} == assumed
    for library in ("numba", "llvmlite", "h5py", "hdf5", "python"):
        assert attrs[f"{library}_version"][0].isdigit(), library


def test_cells_without_a_piece_say_so(path):
    scan = make_scan()
    write(path, scan, cut(scan)[:1])
    left = {name: values[5:] for name, values in arrays(path).items()}
    assert np.all(left["status"] == 1)
    assert np.all(np.isnan(left["section"]))
    assert set(left["label"].flat) == {""}


def test_foreign_files_and_those_of_the_future_are_refused(path, error_of):
    assert "no such file" in error_of(archive.read, path)
    with h5py.File(path, "w") as file:
        file.attrs["schema"] = 1
    assert "not an archive" in error_of(archive.read, path)
    for schema in (1, 99):  # 1: the foot's force was the cosine, x1 absolute
        with h5py.File(path, "w") as file:
            file.attrs.update(schema=schema, scan_hash="0")
            file["status"] = [0]
        assert f"schema {schema}: this version reads 2" in error_of(archive.read, path)
    for data in (b"", b"not HDF5", b"\x89HDF\r\n\x1a\n" + bytes(3000)):
        path.write_bytes(data)
        assert "cannot be opened" in error_of(archive.read, path)


def test_what_was_not_recorded_is_unknown_and_nothing_is_damaged(path, error_of):
    """Each way to ask for a dataset, by a name that is not there and by what is no name."""
    write(path, make_scan(want=["energy"]))
    with archive.read(path) as view:
        ways = [view.dims, view.shape, view.take, view.units, view.long_name, view.describe]
        ways += [view.flags, view.__getitem__]
        for way in ways:
            for name in ("lyapunov", [1, 2], 3, None, b"E1max"):
                line = error_of(way, name)
                assert "unknown dataset" in line
                assert "E1max" in line
        assert [1, 2] not in view
        assert "E1max" in view


@pytest.mark.parametrize(
    ("name", "step"), [("section", 37), ("label", 5), ("E1max", 3), ("omega", 3)]
)
def test_each_flipped_byte_of_a_dataset_is_named(path, error_of, name, step):
    write(path, make_scan())
    with h5py.File(path) as file:
        dataset = file[name].id
        assert dataset.get_num_chunks() == 1
        chunk = dataset.get_chunk_info(0)
    whole = path.read_bytes()
    for place in range(chunk.byte_offset, chunk.byte_offset + chunk.size, step):
        path.write_bytes(whole[:place] + bytes([whole[place] ^ 255]) + whole[place + 1 :])
        with archive.read(path) as view:
            assert f"dataset {name} is" in error_of(view.__getitem__, name)


def test_permission_denied_is_said_as_such(here, monkeypatch, refusal):
    write(here / "scan.h5", make_scan())
    really = os.open

    def refused(place, *arguments, **keywords):
        if str(place) == "scan.h5":
            raise PermissionError(errno.EACCES, os.strerror(errno.EACCES), str(place))
        return really(place, *arguments, **keywords)

    monkeypatch.setattr(os, "open", refused)
    for words in (["export"], ["plot", "--show", "?"], ["rerun"]):
        err = refusal(*words, "scan.h5")
        assert "Permission denied" in err
        assert "damaged" not in err


def test_a_picture_is_drawn_through_a_link(path):
    write(path, make_scan())
    target = path.with_name("target.png")
    path.with_name("link.png").symlink_to(target)
    PICTURE.save(path, path.with_name("link.png"))
    assert path.with_name("link.png").is_symlink()
    assert target.read_bytes()[1:4] == b"PNG"


def test_what_is_printed_fits_any_terminal(monkeypatch):
    """Nothing moves a cursor, changes colors, hides text or breaks a line."""
    screen = io.TextIOWrapper(io.BytesIO(), encoding="ascii")
    monkeypatch.setattr(sys, "stdout", screen)
    say("π T,1", "red \x1b[31m, \x9b2J, \u202edlo, \u2028 and a bell \a")
    assert screen.buffer.getvalue().decode("ascii").count("\n") == 2


@pytest.mark.parametrize(
    ("title", "end"),
    [("$\\frac", "svg"), ("a $x^{ b $ c", "pdf"), ("100 $ \\$", "png"), ("減衰 ₁", "png")],
)
def test_a_title_is_drawn_letter_by_letter(path, title, end):
    scan = nv.load_scan(make_scan(("energy", "regime")).document() | {"title": title})
    write(path, scan)
    PICTURE.save(path, path.with_suffix(f".{end}"))


@pytest.mark.parametrize("value", [1.7e308, -1.7e308, np.inf, 5e-324])
@pytest.mark.parametrize("vary", [None, MAP])
def test_a_picture_copes_with_the_largest_numbers(path, value, vary):
    scan = make_scan(("energy", "regime", "lyapunov"), vary=vary)

    def largest(block):
        arrays = results(scan, block)
        for entry in scan.table.datasets.values():
            if entry.dtype == "float64":
                arrays[entry.name] = np.full_like(arrays[entry.name], value)
        return arrays

    written(path, scan, cut(scan), largest)
    for show in (None,) if vary is None else ("E1max", "lyapunov"):
        PICTURE.save(path, path.with_suffix(".png"), show)
