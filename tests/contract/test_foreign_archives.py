"""Files that this program has not written so: archives, parts, what has taken their names."""

import errno
import io
import json
import os
import shutil
import sys
from types import ModuleType, SimpleNamespace

import h5py
import numpy as np
import pytest
from made_up import MAP, arrays, cut, fill, finished, make_scan, results, same, write

import nlds_vines as nv
from nlds_vines.__main__ import main
from nlds_vines.archives import archive, durable
from nlds_vines.archives.view import whole_crc
from nlds_vines.bifurcation import blocks as cutting
from nlds_vines.bifurcation.block_files import Parts
from nlds_vines.bifurcation.blocks import blocks_of
from nlds_vines.bifurcation.picture.drawing import PICTURE
from nlds_vines.cli.command_main import say
from nlds_vines.errors import RequestError, printable
from nlds_vines.runs.manifest import Manifest

ESCAPE = "red \x1b[31m, \x9b2J, \u202edlo, \u2028 and a bell \a"
"""What moves a cursor, changes colours, hides text or breaks a line."""


@pytest.fixture
def path(here, monkeypatch):
    monkeypatch.setattr(cutting, "_block_cells", lambda _: 5)
    return here / "scan.h5"


# ---- a file under the archive's name -------------------------------------------------------------


@pytest.mark.parametrize("links", [True, False])
@pytest.mark.parametrize("kind", ["file", "link", "folder"])
def test_what_comes_into_being_meanwhile_is_kept(path, monkeypatch, links, kind):
    scan = make_scan()
    if not links:  # FAT and some network file systems have no hard links

        def refuse(*_, **__):
            raise OSError(errno.EPERM, "Operation not permitted")

        monkeypatch.setattr(os, "link", refuse)
    with Parts.open(path, scan) as parts:
        fill(parts, scan, cut(scan))
        if kind == "file":
            path.write_bytes(b"precious")
        elif kind == "link":
            path.symlink_to("nowhere")
        else:
            path.mkdir()
        with pytest.raises(RequestError, match=r"meanwhile.*scan\.h5\.parts.*--resume"):
            parts.consolidate(cut(scan), {})
    if kind == "file":
        assert path.read_bytes() == b"precious"
    assert path.is_symlink() == (kind == "link")
    assert not (path.parent / "nowhere").exists()
    path.rename(path.with_name("moved"))
    with Parts.open(path, scan, resume=True) as parts:
        assert finished(parts, cut(scan)) == {0, 1, 2}
        parts.consolidate(cut(scan), {})
    assert archive.verify(path) == []
    assert sorted(os.listdir(path.parent)) == ["moved", "scan.h5"]


def test_a_run_with_overwrite_replaces_what_came_meanwhile(path):
    scan = make_scan()
    with Parts.open(path, scan, overwrite=True) as parts:
        fill(parts, scan, cut(scan))
        path.write_bytes(b"old")
        parts.consolidate(cut(scan), {})
    assert archive.verify(path) == []


@pytest.mark.parametrize("apart", [False, True])
def test_overwriting_a_link_replaces_what_it_points_to(path, monkeypatch, apart):
    scan, target = make_scan(), path.parent / "deep" / "target.h5"
    target.parent.mkdir()
    target.write_bytes(b"old")
    path.symlink_to("deep/target.h5")
    if apart:  # the target lies on another file system
        rename = os.replace

        def across(one, other):
            if os.path.dirname(one) != os.path.dirname(other):
                raise OSError(errno.EXDEV, "Invalid cross-device link")
            rename(one, other)

        monkeypatch.setattr(os, "replace", across)
    write(path, scan, overwrite=True)
    assert path.is_symlink()
    assert not target.is_symlink()
    assert archive.verify(target) == []
    assert os.listdir(target.parent) == ["target.h5"]
    assert sorted(os.listdir(path.parent)) == ["deep", "scan.h5"]


def test_a_picture_is_drawn_through_a_link(path):
    write(path, make_scan())
    target = path.with_name("target.png")
    path.with_name("link.png").symlink_to(target)
    PICTURE.save(path, path.with_name("link.png"))
    assert path.with_name("link.png").is_symlink()
    assert target.read_bytes()[1:4] == b"PNG"


# ---- parts ---------------------------------------------------------------------------------------


@pytest.fixture
def begun(path):
    scan = make_scan()
    with Parts.open(path, scan) as parts:
        fill(parts, scan, blocks_of(scan))
    return parts.folder


def test_verify_names_every_damage_whatever_lies_there(begun, ask):
    first, second, third = sorted(begun.glob("block-*"))
    first.unlink()
    first.mkdir()
    second.unlink()
    os.mkfifo(second)
    third.write_bytes(third.read_bytes()[:-7])
    (begun / "block-000007.part").mkdir()
    other = write(begun.with_name("other.h5"), make_scan())
    out, err = ask("verify", "no.h5", begun, other, status=2)
    assert err.count("\n") == 1
    assert "'no.h5'" in err
    for name in (first.name, second.name, third.name, "block-000007.part"):
        assert name in out
    assert f"{other}: sound" in out
    assert main(["verify", str(begun)]) == 1


def test_a_folder_in_the_place_of_a_part_is_named_and_kept(begun, path, answer):
    part = min(begun.glob("block-*"))
    part.unlink()
    (part / "precious").mkdir(parents=True)
    assert "1 unreadable" in answer("status", path)
    with (
        Parts.open(path, make_scan(), resume=True) as parts,
        pytest.raises(RequestError, match=r"block-000000\.part is a folder"),
    ):
        list(parts.sound(blocks_of(make_scan())))
    assert (part / "precious").is_dir()


def test_a_pipe_in_the_place_of_a_part_is_computed_again(begun, path):
    part = min(begun.glob("block-*"))
    part.unlink()
    os.mkfifo(part)
    with Parts.open(path, make_scan(), resume=True) as parts:
        assert finished(parts, blocks_of(make_scan())) == {1, 2}
        assert "no regular file" in parts.discarded[0]


def test_a_lock_that_is_a_pipe_does_not_hang(begun, path, capsys):
    (begun / "lock").unlink(missing_ok=True)
    os.mkfifo(begun / "lock")
    os.mkfifo(begun / "shard-1-of-2.lock")
    assert main(["status", str(path)]) == 0


def test_parts_with_odd_headers_are_damaged_and_no_more(begun, ask):
    part = min(begun.glob("block-*"))
    head = json.loads(durable.read(part).split(b"\n", 1)[0])
    for change in (
        {"made": {"by": {}, "seconds": "x", "threads": 1}},
        {"made": {"\x1b[31m": 1}},
        {"arrays": [["status", "|O", [5, 1]]]},
        {"arrays": [["status", "<f8", [10**9]]]},
        {"arrays": 3},
    ):
        durable.write(part, json.dumps(head | change).encode() + b"\n")
        for command, status in (("verify", 1), ("status", 0)):
            out, err = ask(command, begun, status=status)
            assert err == ""
            assert all(printable(line) == line for line in out.splitlines())
    durable.write(part, b"[" * 100_000 + b"\n")
    assert main(["verify", str(begun)]) == 1


# ---- archives ------------------------------------------------------------------------------------


def changed(path, change):
    """Change an archive, and give it the seal that belongs to it then."""
    with h5py.File(path, "r+") as file:
        change(file)
    durable.seal(path)


def each_command(path, other):
    """The commands that read an archive."""
    return (
        ["verify", str(path)],
        ["status", str(path)],
        ["rerun", str(path), "-o", "again.h5", "--dry-run"],
        ["diff", str(path), str(other)],
        ["diff", str(other), str(path)],
    )


def assert_in_words(path, other, capsys, statuses=(0, 1, 2)):
    """Assert that every reader of an archive ends with a status and, where it is 2, one line."""
    before = set(os.listdir())
    found = []
    for arguments in each_command(path, other):
        found.append(main(arguments))
        out, err = capsys.readouterr()
        assert err.count("\n") == (found[-1] == 2), (arguments, err)
        assert "Traceback" not in err
        assert all(printable(line) == line for line in (out + err).splitlines())
    assert set(found) <= set(statuses), found
    found.append(status_of_picture(path))
    assert set(os.listdir()) == before
    return found


def status_of_picture(path):
    """Return 0 if an archive can be drawn, 2 if it is refused in one line."""
    try:
        os.unlink(PICTURE.save(path, "picture.png"))
        return 0
    except RequestError as error:
        return 2 if "\n" not in str(error) else None


def put(name, value):
    def change(file):
        file.attrs.pop(name, None)
        if value is not None:
            file.attrs[name] = value

    return change


@pytest.fixture
def no_estimate(monkeypatch):
    """Let a dry run end before the kernels are loaded."""
    fake = ModuleType("nlds_vines.bifurcation.estimate")
    fake.estimate = lambda *_: SimpleNamespace(lines=lambda: ["an estimate"])
    monkeypatch.setitem(sys.modules, fake.__name__, fake)


VALUES = {
    "missing": None,
    "a number": 3,
    "an array": np.zeros(3),
    "texts": ["a", "b"],
    "bytes": np.bytes_(b"\xff\xfe"),
    "nothing": h5py.Empty("f8"),
    "no TOML": "=",
    "odd TOML": "a = [1.0, 2.0, 'x', [1], 3.0]",
}


@pytest.mark.parametrize("name", ["title", "scan", "scan_hash", "content", "schema", "source"])
@pytest.mark.parametrize("value", VALUES)
def test_odd_attributes_are_told_in_one_line(path, capsys, no_estimate, name, value):
    other = write(path.with_name("other.h5"), make_scan(("energy", "regime")))
    write(path, make_scan(("energy", "regime")))
    changed(path, put(name, VALUES[value]))
    found = assert_in_words(path, other, capsys)
    if name in ("title", "scan", "scan_hash") and value == "missing":
        assert found[0] != 0


def outside(kind, target):
    """Replace E1max by something that leads to another file."""

    def change(file):
        shape = file["E1max"].shape
        del file["E1max"]
        if kind == "external link":
            file["E1max"] = h5py.ExternalLink(str(target), "/E1max")
        elif kind == "soft link":
            file["E1max"] = h5py.SoftLink("/E2max")
        elif kind == "dangling link":
            file["E1max"] = h5py.SoftLink("/no")
        elif kind == "external storage":
            where = [(str(target), 0, h5py.h5f.UNLIMITED)]
            made = file.create_dataset("E1max", shape, "f8", external=where)
            made.attrs.update(units="J", long_name="")
        elif kind == "virtual":
            layout = h5py.VirtualLayout(shape, "f8")
            layout[...] = h5py.VirtualSource(str(target), "E1max", shape)
            file.create_virtual_dataset("E1max", layout)
        else:
            file.create_group("E1max")

    return change


@pytest.mark.parametrize(
    "kind",
    ["external link", "soft link", "dangling link", "external storage", "virtual", "group"],
)
@pytest.mark.parametrize("pipe", [False, True])
def test_what_leads_outside_is_no_archive_and_not_followed(path, capsys, no_estimate, kind, pipe):
    other = write(path.with_name("other.h5"), make_scan(("energy", "regime")))
    target = path.with_name("target.h5")
    if pipe:  # to open it would hang
        os.mkfifo(target)
    else:
        shutil.copy(other, target)
    write(path, make_scan(("energy", "regime")))
    changed(path, outside(kind, target))
    problems = nv.verify(path)
    assert any("E1max" in line for line in problems)
    assert assert_in_words(path, other, capsys)[1:] == [2, 2, 2, 2, 2]
    with pytest.raises(RequestError, match="E1max"), nv.read(path):
        pass


def missing(name):
    return lambda file: file.pop(name)


def replaced(name, values, dims=()):
    def change(file):
        attrs = dict(file[name].attrs) if name in file else {}
        file.pop(name, None)
        dataset = file.create_dataset(name, data=values)
        dataset.attrs.update({k: attrs[k] for k in ("units", "long_name") if k in attrs})
        for side, dim in enumerate(dims):
            dataset.dims[side].attach_scale(file[dim])

    return change


def overwritten(name, value):
    def change(file):
        file[name][0] = value

    return change


DATASETS = {
    "no status": missing("status"),
    "no scale": missing("omega"),
    "no label": missing("label"),
    "no energy": missing("E1max"),
    "status of another shape": replaced("status", np.zeros((3, 1), "i1"), ("omega", "start")),
    "status without dimensions": replaced("status", np.zeros((13, 1), "i1")),
    "a single status": replaced("status", np.int8(0)),
    "status in words": replaced("status", np.array([["a"]] * 13, "S1"), ("omega", "start")),
    "energies in words": replaced(
        "E1max", np.array([["a"]] * 13, dtype=h5py.string_dtype()), ("omega", "start")
    ),
    "compound energies": replaced("E1max", np.zeros((13, 1), [("a", "f8")]), ("omega", "start")),
    "complex energies": replaced("E1max", np.zeros((13, 1), complex), ("omega", "start")),
    "labels in numbers": replaced("label", np.zeros((13, 1)), ("omega", "start")),
    "labels beyond knowledge": replaced(
        "label",
        np.array([["$\\foo$ \x1b[31m"]] * 13, dtype=h5py.string_dtype()),
        ("omega", "start"),
    ),
    "NaN in a scale": overwritten("omega", np.nan),
    "infinity in a scale": overwritten("omega", np.inf),
    "a scale that falls": overwritten("omega", 99.0),
    "a scale of words": replaced("start", np.array(["rest", "up"], dtype=h5py.string_dtype())),
    "something more": replaced("more", np.zeros(3)),
    "petabytes": lambda file: file.create_dataset("more", (10**15,), "f8", chunks=(10**6,)),
}


@pytest.mark.parametrize("case", DATASETS)
@pytest.mark.parametrize("vary", [None, MAP])
def test_odd_datasets_are_told_in_one_line(path, capsys, no_estimate, case, vary):
    scan = make_scan(("energy", "regime"), vary=vary)
    other = write(path.with_name("other.h5"), scan)
    write(path, scan)
    if vary is not None and case.split()[0] in ("status", "energies", "labels", "compound"):
        pytest.skip("a diagram's shape")
    changed(path, DATASETS[case])
    found = assert_in_words(path, other, capsys)
    if "scale" in case or case in ("petabytes", "something more", "status of another shape"):
        assert found[0] == 1


@pytest.mark.parametrize("left", [0, 1, 100, 5000, -100])
def test_truncated_archives_are_told_in_one_line(path, capsys, no_estimate, left):
    other = write(path.with_name("other.h5"), make_scan(("energy", "regime")))
    path.write_bytes(other.read_bytes()[:left])
    assert assert_in_words(path, other, capsys)[0] == 1


def test_escape_sequences_do_not_reach_the_terminal(path, capsys, ask, no_estimate):
    scan = make_scan(("energy", "regime"))
    other = write(path.with_name("other.h5"), scan)
    write(path, scan)

    def change(file):
        for name in ("title", "source", "machine", "numpy_version"):
            file.attrs[name] = ESCAPE
        file.attrs["scan"] = file.attrs["scan"].replace("ssul-set6", "\\u001b[31m")
        file["label"][...] = ESCAPE
        file["label"].attrs["crc32"] = np.uint32(whole_crc(file["label"]))

    changed(path, change)
    assert_in_words(path, other, capsys)
    out, _ = ask("status", path)
    assert "\\x1b[31m" in out
    assert "\x1b" not in out


def test_a_title_in_a_manifest_does_not_reach_the_terminal_either(begun, path, capsys):
    found = Manifest.read(begun)
    words = vars(found) | {"title": ESCAPE, "toml": found.toml.replace("a test", "b\\u001b[31m")}
    durable.write(begun / "manifest.json", json.dumps(words).encode())
    for arguments in (["status", str(path)], ["verify", str(begun)], ["consolidate", str(path)]):
        main(arguments)
        out, err = capsys.readouterr()
        assert all(printable(line) == line for line in (out + err).splitlines())


def test_what_is_printed_fits_any_terminal(path, capsys, monkeypatch):
    screen = io.TextIOWrapper(io.BytesIO(), encoding="ascii")
    monkeypatch.setattr(sys, "stdout", screen)
    say("π T,1", ESCAPE)
    assert screen.buffer.getvalue().decode("ascii").count("\n") == 2


@pytest.mark.parametrize("title", ["$\\frac", "a $x^{ b $ c", "100 $ \\$", "減衰 ₁"])
def test_a_title_is_drawn_letter_by_letter(path, title):
    scan = nv.load_scan(make_scan(("energy", "regime")).document() | {"title": title})
    write(path, scan)
    for end in ("png", "svg", "pdf"):
        PICTURE.save(path, path.with_suffix(f".{end}"))


@pytest.mark.parametrize("value", [1.7e308, -1.7e308, np.inf, 5e-324])
@pytest.mark.parametrize("vary", [None, MAP])
def test_a_picture_copes_with_the_largest_numbers(path, value, vary):
    scan = make_scan(("energy", "regime", "lyapunov"), vary=vary)
    with Parts.open(path, scan) as parts:
        for block in cut(scan):
            found = results(scan, block)
            for entry in scan.table.datasets.values():
                if entry.dtype == "float64":
                    found[entry.name] = np.full_like(found[entry.name], value)
            parts.write(block, found)
        parts.consolidate(cut(scan), {})
    for show in (None,) if vary is None else ("E1max", "lyapunov", "reduction"):
        PICTURE.save(path, path.with_suffix(".png"), show)


def test_archives_that_are_sound_stay_sound(path):
    for vary in (None, MAP):
        write(path, make_scan(vary=vary), overwrite=True)
        assert nv.verify(path) == []
        assert same(arrays(path), arrays(path))
