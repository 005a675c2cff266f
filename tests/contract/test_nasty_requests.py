"""Nasty requests, through every command: status 2, one line, at once, and nothing left behind.

Command lines and files are those of `test_refusals`; here are environments, Python, and odd texts.
"""

import json
import sys
import time
from pathlib import Path

import numpy as np
import pytest
from commands import printed
from made_up import make_scan, write

import nlds_vines as nv
from nlds_vines.errors import MOST_CHARACTERS, RequestError
from nlds_vines.model.axis import Axis
from nlds_vines.model.system import System
from nlds_vines.runs.manifest import Manifest
from nlds_vines.runs.threads import check_environment
from paper.request_file import load_figure

ODD = "a\udcff"  # how Python keeps the bytes a\xff
SLOW = 2.0  # s of computing: far less than what is refused would take, and kernels are not loaded

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

ENVIRONMENTS = {
    "no threads": ({"NUMBA_NUM_THREADS": "0"}, "NUMBA_NUM_THREADS = '0'"),
    "threads in words": ({"NUMBA_NUM_THREADS": "abc"}, "from 1 to 4096"),
    "no number": ({"NUMBA_NUM_THREADS": ""}, "NUMBA_NUM_THREADS = ''"),
    "threads in Arabic": ({"NUMBA_NUM_THREADS": "٣"}, "NUMBA_NUM_THREADS"),
    "too many threads": ({"NUMBA_NUM_THREADS": "100000"}, "from 1 to 4096"),
}


@pytest.mark.parametrize("case", ENVIRONMENTS)
def test_an_environment_that_numba_refuses_is_one_line(case, here, monkeypatch, refusal):
    variables, named = ENVIRONMENTS[case]
    with pytest.raises(RequestError, match="in the environment"):
        check_environment(variables)
    for name, value in variables.items():
        monkeypatch.setenv(name, value)
    for command in ("bifurcation", "tuning", "transients", "portrait", "accuracy"):
        err = refusal(command)
        assert named in err
    assert list(here.iterdir()) == []
    if "simulate" not in vars(nv):  # loaded before: then Numba has read its environment
        with pytest.raises(RequestError, match="in the environment"):
            _ = nv.simulate


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


# ---- the same in Python --------------------------------------------------------------------------


def test_python_refuses_the_same():
    with pytest.raises(RequestError, match="null character"):
        nv.load_scan({"title": "a\0b", "system": "tmd", "vary": {"P": {"values": [1.0]}}})
    known = nv.load_system("tmd").parameters
    for name, words in (("a\0", "null"), (ODD, "UTF-8"), ("\x1b[2J", "control"), (3, "a string")):
        with pytest.raises(RequestError, match=words):
            System("tmd", known, name=name)
        with pytest.raises(RequestError, match=words):
            System("tmd", known, assumptions={"m1": name})
    with pytest.raises(RequestError, match=r"characters; allowed: up to 1000"):
        System("tmd", known, title="x" * (MOST_CHARACTERS + 1))


def test_texts_that_people_write_are_taken():
    for title in ("Größe β = 2 π, 減衰", "a 👩‍🔬 b", "$5 \\frac", "x" * MOST_CHARACTERS):
        assert System("tmd", nv.load_system("tmd").parameters, title=title).title == title
    note = "first line\n\tsecond line"
    system = System("tmd", nv.load_system("tmd").parameters, assumptions={"m1": note})
    assert system.assumptions["m1"] == note


def test_an_axis_of_ten_million_values_takes_a_moment():
    began = time.process_time()
    assert Axis.spaced("P", 1.0, 2.0, 10**7).values.size == 10**7
    assert time.process_time() - began < SLOW
    with pytest.raises(RequestError, match="nan must be a finite number"):
        Axis("P", np.array([1.0, np.nan]))


def test_an_archive_made_from_a_program_with_an_odd_name_can_be_written(tmp_path, monkeypatch):
    monkeypatch.setattr(sys, "argv", [f"/home/{ODD}/run.py", "a\0b"])
    path = write(tmp_path / "a.h5", make_scan())
    with nv.read(path) as view:
        assert json.loads(view.attrs["argv"]) == sys.argv
    assert Manifest.of(make_scan()).argv == sys.argv


def test_a_file_beyond_all_reason_is_not_read(tmp_path):
    path = tmp_path / "huge.toml"
    with path.open("wb") as file:
        file.truncate(10**12)  # a hole: it takes no room
    with pytest.raises(RequestError, match="1000000000000 bytes; allowed"):
        nv.load_scan(path)


@pytest.mark.parametrize("name", ["../../escaped", "/tmp/escaped", "a/b", "ω" * 900, ".hidden"])
def test_a_name_in_a_figure_is_no_path(tmp_path, name):
    text = SYSTEM.format(more=f'omega = 1\nname = "{name}"') + "[[curves]]\n"
    (tmp_path / "page.toml").write_text(text)
    request = load_figure(tmp_path / "page.toml")
    (archive,) = (request.archive(curve) for curve in request.curves)
    assert Path(archive).name == archive
    assert not archive.startswith(".")
    assert len(archive.encode()) < 255
