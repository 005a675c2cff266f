"""A new task is a folder and two lines: made here in a copy, by a diff."""

import json

import commands
import numpy as np
import pytest
from support import amplitudes

import nlds_vines as nv

PROGRAM = """
import json
from pathlib import Path
import nlds_vines as nv
from nlds_vines.__main__ import main
Path("own.toml").write_text("system = 'tmd'\\n[set]\\nc1 = 400.0\\n[band]\\ncount = 4\\n")
frf = ["frf", "own.toml", "-o", "own.h5", "--high", "6.5", "--quiet"]
assert main([*frf, "--plot", "own.png"]) == 0
assert main([*frf, "--resume"]) == 0  # complete already
assert main(["plot", "own.h5", "-o", "own.svg"]) == 0
assert main(["export", "own.h5", "-o", "own.csv"]) == 0
assert main(["rerun", "own.h5", "-o", "again.h5"]) == 0
assert all(Path(name).stat().st_size > 0 for name in ("own.png", "own.svg", "own.csv"))
one, other = nv.open_archive("own.h5"), nv.frf("own.toml", quiet=True, band={"high": 6.5})
assert one.request.hash == other.request.hash
print(json.dumps([one.omega.tolist(), one.x1.tolist(), other.x1.tolist(), one.lines()]))
"""


@pytest.fixture(scope="module")
def changed(tmp_path_factory):
    """Return a function that runs Python in a changed copy."""
    folder = commands.changed(tmp_path_factory.mktemp("changed"), "task")
    return lambda *words: commands.python(*words, cwd=folder, PYTHONPATH=str(folder))


def test_it_is_a_command_a_file_a_function_and_an_archive(changed):
    done = changed("-c", PROGRAM)
    assert done.returncode == 0, done.stderr
    omega, x1, again, lines = json.loads(done.stdout.splitlines()[-1])
    np.testing.assert_array_equal(omega, np.linspace(5.0, 6.5, 4))
    p = nv.load_system("tmd", c1=400.0).parameters
    alone = [abs(amplitudes({**p, "omega": value})[0]) for value in omega]
    np.testing.assert_allclose(x1, alone, rtol=1e-12)
    assert x1 == again
    assert lines == [f"largest x1: {max(x1):.6g} m at 6.0 rad/s".replace("6.0", "6")]


def test_its_options_are_told_and_refused(changed):
    text = changed("-m", "nlds_vines", "frf", "--help")
    assert "lowest frequency [rad/s] [5]" in text.stdout
    assert "frf" in changed("-m", "nlds_vines", "--help").stdout
    for words, line in (
        (["--low", "9"], "command line: [band]: low = 9 must be below high = 8"),
        (["--count", "1"], "command line: [band]: count = 1 must be a whole number from 2"),
    ):
        done = changed("-m", "nlds_vines", "frf", *words)
        assert done.returncode == 2
        assert done.stderr.startswith(f"nlds-vines frf: error: {line}")
        assert done.stderr.count("\n") == 1


def test_what_it_takes_is_told_and_what_exists_is_kept(changed):
    dry = changed("-m", "nlds_vines", "frf", "-o", "kept.h5", "--dry-run")
    assert dry.returncode == 0, dry.stderr
    assert "archive:  kept.h5" in dry.stdout
    assert changed("-m", "nlds_vines", "frf", "-o", "kept.h5", "--quiet").returncode == 0
    done = changed("-m", "nlds_vines", "frf", "-o", "kept.h5", "--low", "6")
    assert done.returncode == 2
    assert "kept.h5' exists" in done.stderr
