"""Files that this program has not written so: archives, blocks, what has taken their names."""

import errno
import io
import os
import sys

import numpy as np
import pytest
from made_up import MAP, arrays, cut, make_scan, results, write

import nlds_vines as nv
from nlds_vines.bifurcation import blocks as cutting
from nlds_vines.bifurcation.picture.drawing import PICTURE
from nlds_vines.cli.terminal import say
from nlds_vines.errors import RequestError
from nlds_vines.runs.store import Blocks
from scans import written

ESCAPE = "red \x1b[31m, \x9b2J, \u202edlo, \u2028 and a bell \a"
"""What moves a cursor, changes colors, hides text or breaks a line."""


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

    def meanwhile(block):
        if block.index == 2:
            if kind == "file":
                path.write_bytes(b"precious")
            elif kind == "link":
                path.symlink_to("nowhere")
            else:
                path.mkdir()
        return results(scan, block)

    with pytest.raises(RequestError, match=r"meanwhile.*scan\.h5\..*\.blocks.*--resume"):
        written(path, scan, cut(scan), meanwhile)
    if kind == "file":
        assert path.read_bytes() == b"precious"
    assert path.is_symlink() == (kind == "link")
    assert not (path.parent / "nowhere").exists()
    path.rename(path.with_name("moved"))
    written(path, scan, cut(scan), None, resume=True)
    assert arrays(path)
    assert sorted(os.listdir(path.parent)) == ["moved", "scan.h5"]


def test_a_run_with_overwrite_replaces_what_came_meanwhile(path):
    scan = make_scan()

    def meanwhile(block):
        path.write_bytes(b"old")
        return results(scan, block)

    written(path, scan, cut(scan), meanwhile, overwrite=True)
    assert arrays(path)


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
    assert arrays(target)
    assert os.listdir(target.parent) == ["target.h5"]
    assert sorted(os.listdir(path.parent)) == ["deep", "scan.h5"]


def test_a_picture_is_drawn_through_a_link(path):
    write(path, make_scan())
    target = path.with_name("target.png")
    path.with_name("link.png").symlink_to(target)
    PICTURE.save(path, path.with_name("link.png"))
    assert path.with_name("link.png").is_symlink()
    assert target.read_bytes()[1:4] == b"PNG"


# ---- what has taken the name of a block ----------------------------------------------------------


def test_a_folder_in_the_place_of_a_block_is_named_and_kept(path):
    place = Blocks(path, make_scan()).file(0)
    (place / "precious").mkdir(parents=True)
    with pytest.raises(RequestError, match=r"cannot write a block in .*directory"):
        write(path, make_scan(), resume=True)
    assert (place / "precious").is_dir()


def test_a_pipe_in_the_place_of_a_block_is_computed_again(path, capsys):
    place = Blocks(path, make_scan()).file(0)
    place.parent.mkdir()
    os.mkfifo(place)
    write(path, make_scan(), resume=True)
    assert "0.npz is computed again: it is no regular file" in capsys.readouterr().err


# ---- archives ------------------------------------------------------------------------------------


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

    def largest(block):
        arrays = results(scan, block)
        for entry in scan.table.datasets.values():
            if entry.dtype == "float64":
                arrays[entry.name] = np.full_like(arrays[entry.name], value)
        return arrays

    written(path, scan, cut(scan), largest)
    for show in (None,) if vary is None else ("E1max", "lyapunov", "reduction"):
        PICTURE.save(path, path.with_suffix(".png"), show)
