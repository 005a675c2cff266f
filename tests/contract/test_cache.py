"""The compiled kernels: found again by the next process, forgotten when any kernel changes."""

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

import nlds_vines
from nlds_vines.kernels import compiling

ROOT = Path(nlds_vines.__path__[0]).parent

PROGRAM = """
import json, pkgutil
from importlib import import_module
from nlds_vines import kernels
from nlds_vines.bifurcation.blocks import Block
from nlds_vines.bifurcation.compute import Computer
from nlds_vines.bifurcation.request_file import load_scan

document = {
    "system": "none",
    "vary": {"omega": {"values": [5.0, 6.0]}},
    "sampling": {"transient": 0, "periods": 12},
    "record": {"want": ["regime"]},
}
arrays = Computer(load_scan(document)).block(Block(0, ((0, 2),)))
names = [f"nlds_vines.kernels.{module.name}" for module in pkgutil.iter_modules(kernels.__path__)]
modules = [import_module(name) for name in names]
found = {id(f): f for m in modules for f in vars(m).values() if hasattr(f, "stats")}
compiled = [f for f in found.values() if not isinstance(f, type)]
print(json.dumps({
    "labels": arrays["label"].ravel().tolist(),
    "home": kernels.__path__[0],
    "hits": sum(sum(f.stats.cache_hits.values()) for f in compiled),
    "misses": sum(sum(f.stats.cache_misses.values()) for f in compiled),
}))
"""


@pytest.fixture
def run(tmp_path):
    """Return a function that runs `PROGRAM` on a copy of the package with a cache of its own."""
    for name in ("nlds_vines", "data", "scans"):
        ignored = shutil.ignore_patterns("__pycache__")
        shutil.copytree(ROOT / name, tmp_path / name, ignore=ignored)

    def program():
        done = subprocess.run(
            [sys.executable, "-c", PROGRAM],
            capture_output=True,
            text=True,
            check=False,
            cwd=tmp_path,
            env={
                **os.environ,
                "PYTHONPATH": str(tmp_path),
                "PYTHONDONTWRITEBYTECODE": "1",
                "NUMBA_CACHE_DIR": str(tmp_path / "cache"),
                "NUMBA_DISABLE_JIT": "0",
            },
        )
        assert done.returncode == 0, done.stderr
        found = json.loads(done.stdout)
        assert found["home"] == str(tmp_path / "nlds_vines" / "kernels")
        return found

    return program


def test_the_second_process_compiles_nothing_and_an_edit_is_seen(run, tmp_path):
    first = run()
    assert first["misses"] > 0
    assert first["hits"] <= 1  # the verdict, where another process has compiled it meanwhile
    assert first["labels"] == ["T,0", "T,0"]

    second = run()
    assert second["hits"] > 0
    assert second["misses"] == 0
    assert second["labels"] == first["labels"]

    # `judge_lanes` stands in another file, and that file does not change
    edited = tmp_path / "nlds_vines" / "kernels" / "settling.py"
    text = edited.read_text()
    assert text.count("MARGIN = 1.0e-6") == 1
    edited.write_text(text.replace("MARGIN = 1.0e-6", "MARGIN = 1.0e+6"))  # nothing is stable
    third = run()
    assert third["misses"] > 0
    assert third["labels"] == ["undetermined", "undetermined"]  # it returns, and nothing draws it


@pytest.mark.parametrize("name", sorted(path.name for path in compiling.KERNELS.glob("*.py")))
def test_the_stamp_knows_every_kernel_file(name, tmp_path, monkeypatch):
    shutil.copytree(compiling.KERNELS, tmp_path / "kernels", ignore=shutil.ignore_patterns("__*__"))
    monkeypatch.setattr(compiling, "KERNELS", tmp_path / "kernels")
    before = compiling.source_stamp.__wrapped__()
    assert compiling.source_stamp.__wrapped__() == before
    with (tmp_path / "kernels" / name).open("a") as file:
        file.write("# a comment\n")
    assert compiling.source_stamp.__wrapped__() != before


# ---- where nothing can be written ----------------------------------------------------------------

BLOCKED = """
from nlds_vines.kernels.elementary import exp
print(exp(1.0))
"""


@pytest.fixture
def blocked(tmp_path):
    """Return a function that runs `BLOCKED` where the program's folder takes no cache.

    A file in its place keeps even the superuser from writing one.
    """
    ignored = shutil.ignore_patterns("__pycache__")
    shutil.copytree(ROOT / "nlds_vines", tmp_path / "nlds_vines", ignore=ignored)
    (tmp_path / "nlds_vines" / "kernels" / "__pycache__").touch()
    (tmp_path / "tmp").mkdir()

    def program(home, temporary):
        environment = {k: v for k, v in os.environ.items() if k != "NUMBA_CACHE_DIR"}
        environment |= {"HOME": str(home), "XDG_CACHE_HOME": f"{home}/cache", "PYTHONPATH": ""}
        environment |= {"TMPDIR": str(temporary), "NUMBA_DISABLE_JIT": "0"}
        done = subprocess.run(
            [sys.executable, "-B", "-c", BLOCKED],
            capture_output=True, text=True, check=False, cwd=tmp_path, env=environment,
        )  # fmt: skip
        assert done.returncode == 0, done.stderr
        assert float(done.stdout) == pytest.approx(2.718281828459045, rel=1e-15)
        return done.stderr

    return program


def compiled_in(folder):
    return list(folder.rglob("*.nbi"))


def test_the_users_cache_is_taken_without_a_word(blocked, tmp_path):
    assert blocked(tmp_path / "home", tmp_path / "tmp") == ""
    assert compiled_in(tmp_path / "home")
    assert not compiled_in(tmp_path / "tmp")


def test_then_a_temporary_folder_that_is_named(blocked, tmp_path):
    said = blocked("/dev/null", tmp_path / "tmp")
    assert said.count("\n") == 1
    assert "NUMBA_CACHE_DIR" in said
    (folder,) = (tmp_path / "tmp").iterdir()
    assert str(folder) in said
    assert folder.stat().st_mode & 0o077 == 0  # Numba runs what it finds there
    assert compiled_in(folder)
    before = {path: path.stat().st_mtime_ns for path in compiled_in(folder)}
    assert str(folder) in blocked("/dev/null", tmp_path / "tmp")  # the same again
    assert {path: path.stat().st_mtime_ns for path in compiled_in(folder)} == before


def test_a_folder_that_others_can_write_to_is_not_taken(blocked, tmp_path):
    theirs = tmp_path / "tmp" / f"nlds_vines-{os.getuid()}"
    theirs.mkdir()
    theirs.chmod(0o777)
    said = blocked("/dev/null", tmp_path / "tmp")
    assert f"{theirs};" not in said
    assert not compiled_in(theirs)


NOWHERE = """
import tempfile
tempfile.gettempdir = lambda: "/dev/null"
"""


def test_without_any_folder_it_works_all_the_same(blocked, monkeypatch):
    monkeypatch.setattr(sys.modules[__name__], "BLOCKED", NOWHERE + BLOCKED)
    said = blocked("/dev/null", "/dev/null")
    assert said.count("\n") == 1
    assert "are lost when the process ends; set NUMBA_CACHE_DIR" in said
