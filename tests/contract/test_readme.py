"""The README does what it says: its blocks run, its commands and files exist."""

import contextlib
import io
import re
import shlex
import subprocess
import sys
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path

import pytest

from nlds_vines.__main__ import COMMANDS
from nlds_vines.__main__ import main as console
from nlds_vines.bifurcation.command import main
from nlds_vines.bifurcation.request_file import load_scan
from nlds_vines.model.catalogue import catalogue
from nlds_vines.model.scenes import SCENES

ROOT = Path(__file__).resolve().parents[2]
TEXT = (ROOT / "README.md").read_text(encoding="utf-8")
BLOCKS = re.findall(r"^```(\w+)\n(.*?)^```$", TEXT, re.MULTILINE | re.DOTALL)


def blocks(language):
    found = [body for name, body in BLOCKS if name == language]
    assert found
    return found


@pytest.fixture
def own(tmp_path, monkeypatch):
    """Work in an empty folder that holds the README's scan file alone."""
    (scan,) = blocks("toml")
    (tmp_path / "own.toml").write_text(scan)
    monkeypatch.chdir(tmp_path)
    return tmp_path / "own.toml"


def test_the_scan_file_means_what_its_comments_say(own):
    scan = load_scan(own)
    assert scan.system.K == 2.5e7
    assert (scan.shape, scan.transient, scan.periods) == ((41, 2), 300, 60)


def test_the_python_examples_print_what_is_shown(own):
    names = {}
    for program, shown in zip(blocks("python"), blocks("text"), strict=True):
        with contextlib.redirect_stdout(io.StringIO()) as printed:
            exec(compile(program, "README.md", "exec"), names)
        assert printed.getvalue() == shown


def commands():
    """Return the words of every command of this program in the README's shell blocks."""
    lines = [part for body in blocks("sh") for part in re.split(r"\n|&&", body) if part.strip()]
    words = [shlex.split(line) for line in lines]
    return [line for line in words if "nlds_vines" in " ".join(line)]


def test_every_command_is_understood(own, monkeypatch):
    found = commands()
    assert len(found) >= 3
    for line in found:
        module, *arguments = line[line.index("-m") + 1 :]
        assert import_module(f"{module}.command").main([*arguments, "--dry-run"]) == 0


def test_the_scan_file_is_computed_and_drawn(own):
    (line,) = [line for line in commands() if "own.toml" in line]
    assert main([*line[line.index("-m") + 2 :], "--quiet"]) == 0
    assert Path("own.h5").stat().st_size > 0
    assert Path("own.png").stat().st_size > 0


def sister_commands(text):
    """Return the words of every line in a text that begins with the console script."""
    lines = re.findall(r"^nlds-vines (.*)$", text, re.MULTILINE)
    return [shlex.split(line) for line in lines]


@pytest.mark.skipif(find_spec("distributed") is None, reason="distributed is not installed")
def test_the_long_scan_goes_on_as_it_is_told(own):
    found = sister_commands("".join(blocks("sh")))
    assert [console(words) for words in found] == [0, 0, 2, 0]  # shards are missing, then done
    assert Path("big.h5").stat().st_size > 0


def test_the_recipes_for_clusters_are_understood(own):
    text = (ROOT / "docs" / "clusters.md").read_text(encoding="utf-8")
    own.rename("map.toml")
    tried = re.findall(r"^<!-- tried: (\w+) -->\n```sh\n(.*?)^```$", text, re.MULTILINE | re.DOTALL)
    assert len(tried) == 2
    for name, block in tried:
        found = [words for words in sister_commands(block) if words[0] == name]
        assert found
        for words in found:
            assert console([*words, "--dry-run"]) == 0
    for name in re.findall(r"nlds-vines (\w+)", text):
        assert name in COMMANDS


FOLDERS = [module.removesuffix(".command") for module, _ in COMMANDS.values()]


@pytest.mark.parametrize(
    "program",
    [
        *(["nlds_vines", name] for name in COMMANDS),
        *([folder] for folder in FOLDERS if "upkeep" not in folder),
    ],
    ids=" ".join,
)
def test_every_command_has_help(program):
    done = subprocess.run(
        [sys.executable, "-m", *program, "--help"], capture_output=True, text=True, check=False
    )
    assert done.returncode == 0
    assert "example" in done.stdout


def test_all_kinds_and_names_are_told():
    for kind in SCENES:
        assert f"`{kind}`" in TEXT
    for name in catalogue():
        stem = re.sub(r"\d$", "", name)
        assert f"`{name}`" in TEXT or f"`{stem}1` to `{stem}6`" in TEXT


def test_the_gate_runs_the_two_commands():
    gate = (ROOT / ".ci" / "run").read_text(encoding="utf-8")
    for name in ("main job", "tests"):
        marker = f"<!-- gate: {name} -->\n```sh\n"
        command, after = TEXT.split(marker)[1].split("\n", 1)
        assert after.startswith("```")
        assert command.startswith("python3 -m venv ")
        assert f'run_command "{name}"' in gate


def test_what_it_points_to_exists():
    links = re.findall(r"\]\(([^)]+)\)", TEXT)
    assert links
    for link in links:
        assert (ROOT / link).is_file(), link
