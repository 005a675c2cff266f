"""Help and a refused request load nothing heavy, so that they answer at once."""

import subprocess
import sys
from pathlib import Path

import pytest

import nlds_vines

HEAVY = ("numba", "llvmlite", "h5py", "matplotlib", "scipy", "tqdm", "bokeh", "tornado")


def loaded(folder: Path, *arguments: str) -> tuple[int, set[str]]:
    """Run Python with these arguments; return its status and the top-level modules it loaded."""
    done = subprocess.run(
        [sys.executable, "-X", "importtime", *arguments],
        capture_output=True,
        text=True,
        cwd=folder,
        env={"PYTHONPATH": str(Path(nlds_vines.__path__[0]).parent)},
        check=False,
    )
    times = (line for line in done.stderr.splitlines() if line.startswith("import time:"))
    return done.returncode, {line.split("|")[-1].strip().split(".")[0] for line in times}


@pytest.mark.parametrize(
    ("arguments", "status"),
    [
        (["--help"], 0),
        (["--system", "nothing"], 2),
        (["nothing.toml"], 2),
        (["--set", "P=nan"], 2),
        (["-o", "no/x.h5"], 2),
        (["-o", "old.h5"], 2),
        (["--plot", "x.gif"], 2),
        (["--shard", "8/7"], 2),
        (["--periods", "1000000000"], 2),
        (["--vary", "omega=5:8:9", "--show", "shares", "-o", "new.h5"], 2),
    ],
)
@pytest.mark.parametrize("program", [["nlds_vines.bifurcation"], ["nlds_vines", "bifurcation"]])
def test_nothing_heavy_is_loaded(program, arguments, status, tmp_path):
    (tmp_path / "old.h5").write_bytes(b"")
    found, modules = loaded(tmp_path, "-m", *program, *arguments)
    assert found == status
    assert "nlds_vines" in modules
    assert not modules & set(HEAVY)


@pytest.mark.parametrize(
    ("arguments", "status"), [(["--help"], 0), (["no.h5"], 2), (["no.h5", "-o", "x.gif"], 2)]
)
def test_plot_loads_nothing_heavy_before_it_must(arguments, status, tmp_path):
    found, modules = loaded(tmp_path, "-m", "nlds_vines", "plot", *arguments)
    assert found == status
    assert not modules & set(HEAVY)


def test_the_page_of_explore_is_made_before_kernels_are_loaded(tmp_path):
    pytest.importorskip("bokeh", reason="Bokeh is not installed")
    parts = ", ".join(f"nlds_vines.explore.{part}" for part in ("shared_map", "server", "session"))
    found, modules = loaded(tmp_path, "-c", f"import {parts}")
    assert found == 0
    assert "bokeh" in modules
    assert not modules & {"numba", "scipy", "matplotlib"}


@pytest.mark.parametrize(("window", "needed"), [("rectangular", False), ("hann", True)])
def test_a_spectrum_loads_scipy_for_a_taper_alone(window, needed, tmp_path):
    make = f"spectrum_of([1.0, 2.0, 1.0, 0.0] * 4, 4, 1.0, window={window!r})"
    found, modules = loaded(
        tmp_path, "-c", f"from nlds_vines.orbits.spectrum import spectrum_of; {make}"
    )
    assert found == 0
    assert ("scipy" in modules) == needed


@pytest.mark.parametrize("command", ["status", "consolidate", "verify", "rerun", "diff"])
@pytest.mark.parametrize(("arguments", "status"), [(["--help"], 0), (["no.h5", "no.h5"], 2)])
def test_sister_commands_load_nothing_heavy(command, arguments, status, tmp_path):
    found, modules = loaded(tmp_path, "-m", "nlds_vines", command, *arguments)
    assert found == status
    assert not modules & set(HEAVY)


@pytest.mark.parametrize(
    ("arguments", "status"),
    [(["--help"], 0), (["no-kind"], 2), (["tmd", "--record", "impacts"], 2)],
)
def test_compiling_ahead_loads_nothing_heavy_before_it_must(arguments, status, tmp_path):
    found, modules = loaded(tmp_path, "-m", "nlds_vines", "compile", *arguments)
    assert found == status
    assert not modules & set(HEAVY)


@pytest.mark.parametrize(
    ("arguments", "status"),
    [(["--help"], 0), (["--dry-run"], 0), (["--free", "k2=2:1"], 2), (["-o", "old.h5"], 2)],
)
def test_tuning_loads_nothing_heavy_before_it_must(arguments, status, tmp_path):
    (tmp_path / "old.h5").write_bytes(b"")
    found, modules = loaded(tmp_path, "-m", "nlds_vines", "tuning", *arguments)
    assert found == status
    assert "nlds_vines" in modules
    assert not modules & set(HEAVY)


@pytest.mark.parametrize(
    ("arguments", "status"),
    [(["--help"], 0), (["--starts", "0"], 2), (["--delay", "-1"], 2), (["-o", "old.h5"], 2)],
)
def test_transients_load_nothing_heavy_before_they_must(arguments, status, tmp_path):
    (tmp_path / "old.h5").write_bytes(b"")
    found, modules = loaded(tmp_path, "-m", "nlds_vines", "transients", *arguments)
    assert found == status
    assert "nlds_vines" in modules
    assert not modules & set(HEAVY)


@pytest.mark.parametrize(
    ("arguments", "status"),
    [
        (["--help"], 0),
        (["--want", "2"], 2),
        (["--stiff"], 2),
        (["-o", "no/x"], 2),
    ],
)
def test_accuracy_loads_nothing_heavy_before_it_must(arguments, status, tmp_path):
    found, modules = loaded(tmp_path, "-m", "nlds_vines", "accuracy", *arguments)
    assert found == status
    assert "nlds_vines" in modules
    assert not modules & set(HEAVY)


@pytest.mark.parametrize(
    ("arguments", "status"),
    [
        (["explore", "--help"], 0),
        (["explore", "--dry-run"], 0),
        (["explore", "--port", "-1"], 2),
        (["explore", "--system", "nothing"], 2),
        (["explore", "no.toml"], 2),
        (["report", "--help"], 0),
        (["report", "no.h5"], 2),
        (["report"], 2),
    ],
)
def test_pages_load_nothing_heavy_before_they_must(arguments, status, tmp_path):
    found, modules = loaded(tmp_path, "-m", "nlds_vines", *arguments)
    assert found == status
    assert not modules & set(HEAVY)


@pytest.mark.parametrize("option", ["--help", "--version"])
def test_the_console_script_itself_loads_nothing_heavy(option, tmp_path):
    found, modules = loaded(tmp_path, "-m", "nlds_vines", option)
    assert found == 0
    assert not modules & set(HEAVY)


def test_systems_and_scans_need_nothing_heavy(tmp_path):
    program = "import nlds_vines.bifurcation.request_file as s; s.load_scan().cells()"
    found, modules = loaded(tmp_path, "-c", program)
    assert found == 0
    assert not modules & set(HEAVY)


def test_the_probe_sees_what_is_loaded(tmp_path):
    found, modules = loaded(tmp_path, "-c", "import h5py")
    assert found == 0
    assert "h5py" in modules
