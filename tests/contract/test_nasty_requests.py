"""Environments and texts that people have: which are taken, and which are refused in one line."""

import json
import sys
from pathlib import Path

import pytest
from commands import printed
from made_up import make_scan, write

import nlds_vines as nv
from nlds_vines.errors import MOST_CHARACTERS
from nlds_vines.model.system import System
from nlds_vines.runs.executors import check_environment
from paper.request import load_figure

ODD = "a\udcff"  # how Python keeps the bytes a\xff

SYSTEM = """\
[system]
kind = "none"
m1 = 1
k1 = 1
c1 = 1
P = 1
{more}
[vary]
omega = {{ values = [6.0, 7.0] }}
"""
# ---- the environment -----------------------------------------------------------------------------


@pytest.mark.parametrize("number", ["0", "abc", "", "٣", "100000"])
def test_threads_that_numba_refuses_are_one_line(number, here, monkeypatch, refusal):
    monkeypatch.setenv("NUMBA_NUM_THREADS", number)
    assert "from 1 to 4096" in refusal("bifurcation")
    assert list(here.iterdir()) == []


def test_usual_environments_are_taken():
    check_environment({})
    check_environment({"NUMBA_NUM_THREADS": " 8 "})


@pytest.mark.kernels
def test_the_threads_of_numba_do_not_matter(tmp_path):
    """The threads are our own: what Numba lacks for its own, or would refuse, is not asked for."""
    arguments = ["bifurcation", "--vary", "omega=6:7:2", "--periods", "1", "--record", "section"]
    layer = {"NUMBA_THREADING_LAYER": "quatsch", "NUMBA_DISABLE_JIT": "1"}
    printed("-m", "nlds_vines", *arguments, "-o", "a.h5", cwd=tmp_path, **layer)
    assert (tmp_path / "a.h5").exists()


def test_texts_that_people_write_are_taken():
    for title in ("Größe β = 2 π, 減衰", "a 👩‍🔬 b", "$5 \\frac", "x" * MOST_CHARACTERS):
        assert System("tmd", nv.load_system("tmd").parameters, title=title).title == title
    note = "first line\n\tsecond line"
    system = System("tmd", nv.load_system("tmd").parameters, assumptions={"m1": note})
    assert system.assumptions["m1"] == note


def test_an_archive_made_from_a_program_with_an_odd_name_can_be_written(tmp_path, monkeypatch):
    monkeypatch.setattr(sys, "argv", [f"/home/{ODD}/run.py", "a\0b"])
    path = write(tmp_path / "a.h5", make_scan())
    with nv.read(path) as view:
        assert json.loads(view.attrs["argv"]) == sys.argv


@pytest.mark.parametrize("name", ["../../escaped", "/tmp/escaped", "a/b", "ω" * 900, ".hidden"])
def test_a_name_in_a_figure_is_no_path(tmp_path, name):
    text = SYSTEM.format(more=f'omega = 1\nname = "{name}"') + "[[curves]]\n"
    (tmp_path / "page.toml").write_text(text)
    request = load_figure(tmp_path / "page.toml")
    archive = request.archive
    assert Path(archive).name == archive
    assert not archive.startswith(".")
    assert len(archive.encode()) < 255
