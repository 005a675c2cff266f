"""A new setting is one field: done here with the change that CONTRIBUTING shows, in a copy."""

import shutil
import subprocess
import sys
from pathlib import Path

import pytest

import nlds_vines as nv

ROOT = Path(__file__).parents[2]

PROGRAM = """
import sys
from nlds_vines.__main__ import main
from nlds_vines.tuning.request_file import load_tuning
if sys.argv[1:]:
    sys.exit(main(sys.argv[1:]))
usual, other = load_tuning("tmd"), load_tuning({"system": "tmd", "search": {"patience": 7}})
assert other.search.patience == 7 and usual.search.patience == 20
assert "patience = 7" in other.to_toml() and "patience" not in usual.to_toml()
assert usual.hash != other.hash == load_tuning(other.document()).hash
print(usual.hash)
"""


@pytest.fixture(scope="module")
def changed(tmp_path_factory):
    """Copy the package, apply the change, and return what runs the copy."""
    folder = tmp_path_factory.mktemp("changed")
    for name in ("nlds_vines", "data"):
        ignored = shutil.ignore_patterns("__pycache__")
        shutil.copytree(ROOT / name, folder / name, ignore=ignored)
    text = (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8").partition("## Add a setting")[2]
    (folder / "change.diff").write_text(text.partition("```diff\n")[2].partition("```\n")[0])
    subprocess.run(["git", "apply", "--unsafe-paths", "change.diff"], cwd=folder, check=True)

    def run(*arguments):
        command = [sys.executable, "-c", PROGRAM, *arguments]
        return subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)

    return run


def test_files_and_hashes_know_it(changed):
    done = changed()
    assert done.returncode == 0, done.stderr
    assert done.stdout.strip() == nv.load_tuning("tmd").hash  # as it was without the setting


def test_it_has_an_option_with_help_and_refusal(changed):
    assert "generations without gain that end a search [20]" in changed("tuning", "--help").stdout
    done = changed("tuning", "--patience", "0")
    assert done.returncode == 2
    assert done.stderr == (
        "nlds-vines tuning: error: command line: [search]: "
        "patience = 0 must be a whole number from 1 to 1000\n"
    )
