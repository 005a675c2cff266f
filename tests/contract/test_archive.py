"""Archives: whole or absent, sound or refused, and just what was asked for."""

import os
import random
import signal
import subprocess
import sys
import textwrap

import h5py
import numpy as np
import pytest
import xarray as xr

from nlds_vines import archive, durable
from nlds_vines.errors import RequestError
from nlds_vines.parts import Block, Parts
from nlds_vines.record import WANTS, datasets, sizes
from nlds_vines.scan import load_scan


def make_scan(want=WANTS, vary=None, start=None, system="ssul-set6", **settings):
    return load_scan(
        {
            "title": "a test",
            "system": system,
            "set": settings,
            "vary": vary or {"omega": {"start": 5.0, "stop": 8.0, "num": 13}},
            "start": start or {"policy": "rest"},
            "sampling": {"transient": 1, "periods": 3},
            "record": {"want": list(want)},
        }
    )


MAP = {
    "omega": {"start": 5.0, "stop": 8.0, "num": 13},
    "P": {"start": 600.0, "stop": 1000.0, "num": 6},
}


def cut(scan, length=5):
    """Cut a scan along its first axis."""
    whole = tuple((0, size) for size in scan.shape[1:])
    firsts = range(0, scan.shape[0], length)
    return [
        Block(i, ((first, min(first + length, scan.shape[0])), *whole))
        for i, first in enumerate(firsts)
    ]


def results(scan, block):
    """Return made-up results: a function of the cell alone, whatever block it is in."""
    length = sizes(scan)
    found = {}
    for entry in datasets(scan):
        shape = tuple(length[dim] for dim in entry.dims)
        rng = np.random.default_rng(len(entry.name))
        if entry.dtype == "str":
            whole = rng.choice(np.array(["T,1", "3T,3", "chaos", "πéà"], dtype=object), shape)
        elif entry.dtype == "float64":
            whole = rng.normal(size=shape)
            whole.flat[:3] = np.inf, np.nan, -0.0
        else:
            whole = rng.integers(0, 5, shape)
        found[entry.name] = whole[block.selection]
    return found


def write(path, scan, blocks=None, **how):
    blocks = cut(scan) if blocks is None else blocks
    with Parts.open(path, scan, **how) as parts:
        for block in blocks:
            parts.write(block, results(scan, block))
        return parts.consolidate(blocks, {"command": "made by a test", "threads": 2})


def arrays(path):
    with archive.read(path) as view:
        return {name: view[name] for name in view.names}


def same(one, other):
    return one.keys() == other.keys() and all(
        one[name].dtype == other[name].dtype
        and (
            one[name].tolist() == other[name].tolist()
            if one[name].dtype == object
            else one[name].tobytes() == other[name].tobytes()
        )
        for name in one
    )


@pytest.fixture
def path(tmp_path):
    return tmp_path / "scan.h5"


# ---- what an archive holds -----------------------------------------------------------------------


@pytest.mark.parametrize("vary", [None, MAP])
def test_round_trip_bit_by_bit(path, vary):
    scan = make_scan(vary=vary, start={"policy": "random", "count": 2, "seed": 3})
    write(path, scan)
    whole = results(scan, Block(0, tuple((0, size) for size in scan.shape)))
    found = arrays(path)
    assert found.keys() == whole.keys()
    for entry in datasets(scan):
        expected = whole[entry.name]
        if entry.dtype == "str":
            assert found[entry.name].tolist() == expected.tolist()
        else:
            assert found[entry.name].dtype == np.dtype(entry.dtype)
            assert found[entry.name].tobytes() == expected.astype(entry.dtype).tobytes()


def test_arrays_do_not_depend_on_how_the_scan_was_cut(tmp_path):
    scan = make_scan(vary=MAP)
    columns = [Block(i, ((0, 13), (2 * i, 2 * i + 2))) for i in range(3)]
    ways = {"one": cut(scan, 13), "rows": cut(scan, 3), "columns": columns}
    found = [arrays(write(tmp_path / f"{way}.h5", scan, blocks)) for way, blocks in ways.items()]
    assert same(found[0], found[1])
    assert same(found[0], found[2])


@pytest.mark.parametrize("want", WANTS)
def test_only_what_was_asked_for_is_there(path, want):
    scan = make_scan(want=[want])
    write(path, scan)
    expected = {entry.name for entry in datasets(scan)}
    dimensions = {dim for entry in datasets(scan) for dim in entry.dims}
    with h5py.File(path) as file:
        assert set(file) == expected | dimensions


@pytest.mark.parametrize("system", ["ssul-set6", "tmd", "none"])
def test_xarray_opens_it_with_dimensions_units_and_flags(path, system):
    want = WANTS if system == "ssul-set6" else ("section", "energy", "regime")
    scan = make_scan(want=want, system=system, vary=MAP)
    write(path, scan)
    with xr.open_dataset(path, engine="h5netcdf") as dataset:
        assert dict(dataset.sizes) == sizes(scan)
        assert dataset.attrs["title"] == "a test"
        assert dataset["omega"].attrs["units"] == "rad/s"
        np.testing.assert_array_equal(dataset["omega"], scan.axes[0].values)
        assert dataset["start"].values.tolist() == ["rest"]
        assert dataset["cycle"].values.tolist() == [1, 2, 3]
        for entry in datasets(scan):
            variable = dataset[entry.name]
            assert variable.dims == entry.dims
            assert variable.attrs["units"] == entry.units
            assert variable.attrs["long_name"] == entry.long_name
        flags = dataset["regime"].attrs
        assert flags["flag_values"].dtype == np.int8
        assert len(flags["flag_values"]) == len(flags["flag_meanings"].split(" "))


def test_attributes_tell_where_it_comes_from(path):
    scan = make_scan()
    write(path, scan)
    with archive.read(path) as view:
        attrs = view.attrs
    assert attrs["scan"] == scan.to_toml()
    assert attrs["scan_hash"] == scan.hash
    assert attrs["schema"] == 1
    assert attrs["history"].endswith("made by a test")
    assert attrs["source"].startswith("nlds_vines ")
    assert attrs["threads"] == 2
    assert attrs["K"] == scan.system.K
    assert {name: attrs[name] for name in scan.system.parameters} == dict(scan.system.parameters)
    assert {name for name in attrs if name.startswith("assumption_")} == {
        f"assumption_{name}" for name in scan.system.assumptions
    }
    assert attrs["numpy_version"] == np.__version__
    assert attrs["numba_version"] != "unknown"


def test_cells_without_a_piece_say_so(path):
    scan = make_scan()
    write(path, scan, cut(scan)[:1])
    found = arrays(path)
    assert np.all(found["status"][5:] == 1)
    assert np.all(np.isnan(found["section"][5:]))
    assert set(found["label"][5:].flat) == {""}


def test_a_view_reads_parts_units_and_flags(path):
    scan = make_scan()
    write(path, scan)
    with archive.read(path) as view:
        assert view.axes == ("omega",)
        assert view.units("section") == "m, m/s"
        assert view.flags("regime")[3] == "chaotic"
        damper = view.take("section", start=0, component=2)
        np.testing.assert_array_equal(damper, view["section"][:, 0, :, 2])
        with pytest.raises(RequestError, match="holds no nothing"):
            view["nothing"]


@pytest.mark.parametrize("content", [b"", b"not HDF5", b"\x89HDF\r\n\x1a\n" + bytes(3000)])
def test_foreign_files_are_refused(path, content):
    path.write_bytes(content)
    with pytest.raises(RequestError, match="cannot be opened"), archive.read(path):
        pass
    assert len(archive.verify(path)) == 2


def test_an_hdf5_file_of_another_program_and_of_the_future_are_refused(path):
    with h5py.File(path, "w") as file:
        file.attrs["schema"] = 1
    with pytest.raises(RequestError, match="not an archive"), archive.read(path):
        pass
    with h5py.File(path, "w") as file:
        file.attrs.update(schema=99, scan_hash="0")
        file["status"] = [0]
    with pytest.raises(RequestError, match="schema 99"), archive.read(path):
        pass
    with pytest.raises(RequestError, match="No such file"):
        archive.verify(path.with_name("absent.h5"))


# ---- existing archives and parts -----------------------------------------------------------------


def test_an_existing_archive_is_refused_and_untouched(path):
    write(path, make_scan())
    before = path.read_bytes()
    with pytest.raises(RequestError, match="--overwrite"):
        Parts.open(path, make_scan())
    with pytest.raises(RequestError, match="another scan"):
        Parts.open(path, make_scan(P=801.0), resume=True)
    assert path.read_bytes() == before
    assert os.listdir(path.parent) == [path.name]


def test_overwrite_keeps_the_old_archive_until_the_new_one_is_there(path):
    old, new = make_scan(), make_scan(P=801.0)
    write(path, old)
    before = path.read_bytes()
    with Parts.open(path, new, overwrite=True) as parts:
        parts.write(cut(new)[0], results(new, cut(new)[0]))
    assert path.read_bytes() == before
    with Parts.open(path, new, resume=True) as parts:  # the interrupted run may go on replacing
        assert parts.finished(cut(new)) == {0}
        for block in cut(new)[1:]:
            parts.write(block, results(new, block))
        parts.consolidate(cut(new), {})
    with archive.read(path) as view:
        assert view.attrs["scan_hash"] == new.hash


def test_resume_of_a_complete_archive_has_nothing_to_do(path):
    write(path, make_scan())
    before = path.read_bytes()
    with Parts.open(path, make_scan(), resume=True) as parts:
        assert parts.complete
    assert path.read_bytes() == before
    assert os.listdir(path.parent) == [path.name]


def test_resume_of_a_damaged_archive_is_refused(path):
    write(path, make_scan())
    flip(path, 3000)
    with pytest.raises(RequestError, match=r"damaged.*--overwrite"):
        Parts.open(path, make_scan(), resume=True)


def test_resume_takes_verified_parts_and_ends_in_the_same_arrays(tmp_path, path):
    scan = make_scan()
    blocks = cut(scan)
    with Parts.open(path, scan) as parts:
        parts.write(blocks[0], results(scan, blocks[0]))
        parts.write(blocks[2], results(scan, blocks[2]))
    with pytest.raises(RequestError, match=r"unfinished run.*--resume.*--overwrite"):
        Parts.open(path, scan)
    with Parts.open(path, scan, resume=True) as parts:
        assert parts.finished(blocks) == {0, 2}
        with pytest.raises(RequestError, match="1 block"):
            parts.consolidate(blocks, {})
        parts.write(blocks[1], results(scan, blocks[1]))
        parts.consolidate(blocks, {})
    assert same(arrays(path), arrays(write(tmp_path / "straight.h5", scan)))
    assert sorted(os.listdir(tmp_path)) == ["scan.h5", "straight.h5"]


def test_parts_cut_otherwise_are_not_taken(path):
    scan = make_scan()
    with Parts.open(path, scan) as parts:
        for block in cut(scan, 5):
            parts.write(block, results(scan, block))
        assert parts.finished(cut(scan, 4)) == set()
        assert len(parts.discarded) == 3


def test_parts_of_another_scan_are_refused_by_name_until_overwritten(path):
    scan, other = make_scan(), make_scan(P=801.0)
    with Parts.open(path, scan) as parts:
        parts.write(cut(scan)[0], results(scan, cut(scan)[0]))
    with pytest.raises(RequestError, match=r"another scan.*a test"):
        Parts.open(path, other, resume=True)
    with Parts.open(path, other, overwrite=True) as parts:
        assert parts.finished(cut(other)) == set()
        assert not parts.discarded


def test_a_part_smuggled_in_from_another_scan_is_found(path):
    scan, other = make_scan(), make_scan(P=801.0)
    with Parts.open(path.with_name("other.h5"), other) as parts:
        parts.write(cut(other)[0], results(other, cut(other)[0]))
        stolen = next(parts.folder.glob("block-*")).read_bytes()
    with Parts.open(path, scan) as parts:
        (parts.folder / "block-000000.npz").write_bytes(stolen)
        assert parts.finished(cut(scan)) == set()
        assert "another scan" in parts.discarded[0]


def test_a_folder_in_which_nothing_was_begun_is_no_hindrance(path):
    parts = Parts.open(path, make_scan())
    parts._manifest_path.unlink()  # killed before it said whose parts these are
    parts.close()
    assert not parts.folder.exists()
    parts.folder.mkdir()
    (parts.folder / "notes.txt").write_text("of the user")
    with Parts.open(path, make_scan()) as parts:
        pass
    write(path, make_scan(), resume=True)
    assert (parts.folder / "notes.txt").exists()


def test_results_of_another_shape_are_a_mistake_of_the_caller(path):
    scan = make_scan()
    block = cut(scan)[0]
    found = results(scan, block)
    with Parts.open(path, scan) as parts:
        with pytest.raises(ValueError, match="shape"):
            parts.write(block, found | {"status": found["status"][1:]})
        with pytest.raises(ValueError, match="holds"):
            parts.write(block, {"status": found["status"]})
        assert parts.finished([block]) == set()


# ---- two runs, killed runs, full disks -----------------------------------------------------------


def run_python(code, **keywords):
    return subprocess.Popen(
        [sys.executable, "-c", textwrap.dedent(code)],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        env={**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)},
        **keywords,
    )


HOLD = """
import sys
from nlds_vines.parts import Parts
from nlds_vines.scan import load_scan
scan = load_scan(sys.stdin.readline().strip())
parts = Parts.open({path!r}, scan)
print("held", flush=True)
sys.stdin.readline()
"""


def test_a_second_run_is_refused_and_a_dead_ones_lock_is_gone(path):
    scan = make_scan()
    file = path.with_name("scan.toml")
    file.write_text(scan.to_toml())
    other = run_python(HOLD.format(path=str(path)), stdin=subprocess.PIPE)
    try:
        other.stdin.write(f"{file}\n")
        other.stdin.flush()
        assert other.stdout.readline() == "held\n", other.stderr.read()
        for how in ({}, {"resume": True}, {"overwrite": True}):
            with pytest.raises(RequestError, match="another run"):
                Parts.open(path, scan, **how)
    finally:
        other.send_signal(signal.SIGKILL)
        other.communicate()
    write(path, scan, resume=True)


@pytest.mark.parametrize("moment", ["archive.write", "durable.seal", "durable.replace"])
@pytest.mark.parametrize("before", [False, True])
def test_an_interrupted_consolidation_leaves_what_was_there(path, monkeypatch, moment, before):
    scan, old = make_scan(), make_scan(P=801.0)
    if before:
        write(path, old)
    was = path.read_bytes() if before else None
    blocks = cut(scan)
    with Parts.open(path, scan, overwrite=True) as parts:
        for block in blocks:
            parts.write(block, results(scan, block))

        def die(*_):
            raise KeyboardInterrupt

        module, name = moment.split(".")
        with monkeypatch.context() as patch:
            patch.setattr({"archive": archive, "durable": durable}[module], name, die)
            with pytest.raises(KeyboardInterrupt):
                parts.consolidate(blocks, {})
    assert (path.read_bytes() if path.exists() else None) == was
    with Parts.open(path, scan, resume=True) as parts:
        assert parts.finished(blocks) == {0, 1, 2}
        parts.consolidate(blocks, {})
    assert archive.verify(path) == []


def test_a_run_killed_after_the_archive_took_its_name_leaves_a_complete_one(path, monkeypatch):
    scan = make_scan()
    blocks = cut(scan)
    with Parts.open(path, scan) as parts:
        for block in blocks:
            parts.write(block, results(scan, block))
        monkeypatch.setattr(Parts, "_clear", lambda _: (_ for _ in ()).throw(KeyboardInterrupt))
        with pytest.raises(KeyboardInterrupt):
            parts.consolidate(blocks, {})
        monkeypatch.undo()
    assert parts.folder.exists()
    with Parts.open(path, scan, resume=True) as parts:
        assert parts.complete
    assert not parts.folder.exists()


def test_an_archive_that_differs_from_its_parts_is_not_put_in_place(path, monkeypatch):
    scan = make_scan()
    blocks = cut(scan)
    crc = archive._crc
    seen = []

    def miscounted(values, start=0):
        seen.append(None)
        return crc(values, start) ^ (len(seen) == 7)

    with Parts.open(path, scan) as parts:
        for block in blocks:
            parts.write(block, results(scan, block))
        monkeypatch.setattr(archive, "_crc", miscounted)
        with pytest.raises(RequestError, match="did not reach the disk"):
            parts.consolidate(blocks, {})
    assert not path.exists()


FULL = """
import resource, signal, sys
sys.path.insert(0, {tests!r})
from test_archive import *
signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
scan = make_scan()
blocks = cut(scan)
with Parts.open({path!r}, scan) as parts:
    for block in blocks:
        parts.write(block, results(scan, block))
    size = max(file.stat().st_size for file in parts.folder.iterdir())
    for limit, act in (
        (size + 9, lambda: parts.consolidate(blocks, dict())),
        (100, lambda: parts.write(blocks[0], results(scan, blocks[0]))),
    ):
        resource.setrlimit(resource.RLIMIT_FSIZE, (limit, resource.RLIM_INFINITY))
        try:
            act()
        except RequestError as error:
            assert str(error).startswith("cannot write"), error
            assert "\\n" not in str(error)
            print("one line", flush=True)
        resource.setrlimit(resource.RLIMIT_FSIZE, (resource.RLIM_INFINITY,) * 2)
"""


def test_a_full_disk_is_one_line_and_the_parts_are_intact(path):
    """A limit on the size of files stands in for the disk: writing fails half-way."""
    tests = os.path.dirname(__file__)
    run = run_python(FULL.format(path=str(path), tests=tests))
    output, errors = run.communicate()
    assert (output, errors) == ("one line\none line\n", "")
    assert not path.exists()
    scan = make_scan()
    with Parts.open(path, scan, resume=True) as parts:
        assert parts.finished(cut(scan)) == {0, 1, 2}
        parts.consolidate(cut(scan), {})
    assert archive.verify(path) == []


def test_a_vanished_or_missing_folder_is_one_line(path):
    scan = make_scan()
    with pytest.raises(RequestError, match="cannot write"):
        Parts.open(path.parent / "nowhere" / "scan.h5", scan)
    parts = Parts.open(path, scan)
    for file in parts.folder.iterdir():
        file.unlink()
    parts.folder.rmdir()
    with pytest.raises(RequestError, match="No such file"):
        parts.write(cut(scan)[0], results(scan, cut(scan)[0]))
    parts.close()


# ---- damage --------------------------------------------------------------------------------------


def flip(path, place, bit=3):
    content = bytearray(path.read_bytes())
    content[place] ^= 1 << bit
    path.write_bytes(content)


def test_every_flipped_bit_of_an_archive_is_found_and_refused_in_one_line(path):
    write(path, make_scan())
    sound = path.read_bytes()
    rng = random.Random(1)
    for _ in range(60):
        path.write_bytes(sound)
        flip(path, rng.randrange(len(sound)), rng.randrange(8))
        problems = archive.verify(path)
        assert problems
        assert not any("\n" in problem for problem in problems)
    path.write_bytes(sound)
    assert archive.verify(path) == []


def test_every_flipped_bit_of_a_part_is_found_and_the_part_removed(path):
    scan = make_scan()
    block = cut(scan)[0]
    rng = random.Random(2)
    with Parts.open(path, scan) as parts:
        parts.write(block, results(scan, block))
        assert parts.finished([block]) == {0}
        file = next(parts.folder.glob("block-*"))
        sound = file.read_bytes()
        for _ in range(60):
            file.write_bytes(sound)
            flip(file, rng.randrange(len(sound)), rng.randrange(8))
            assert parts.finished([block]) == set()
            assert not file.exists()
        assert len(parts.discarded) == 60


@pytest.mark.parametrize("name", ["section", "label", "E1max", "omega"])
def test_damage_is_named_by_dataset(path, name):
    scan = make_scan()
    write(path, scan)
    if name == "label":  # its bytes lie in a heap of the file, beyond the reach of any filter
        place = path.read_bytes().index("πéà".encode())
    else:
        with h5py.File(path) as file:
            place = file[name].id.get_chunk_info(0).byte_offset + 5
    flip(path, place)
    problems = archive.verify(path)
    assert "seal" in problems[0]
    assert [problem.split(" is damaged")[0] for problem in problems[1:]] == [f"dataset {name}"]
    with archive.read(path) as view, pytest.raises(RequestError, match=f"dataset {name}"):
        view[name]


def test_a_changed_attribute_breaks_the_seal(path):
    write(path, make_scan())
    with h5py.File(path, "r+") as file:
        file.attrs["k2"] = 1.0
    assert archive.verify(path) == ["the seal is broken: the file is not as it was written"]


def test_a_cut_file_is_found(path):
    write(path, make_scan())
    path.write_bytes(path.read_bytes()[:-1000])
    assert "seal" in archive.verify(path)[0]
