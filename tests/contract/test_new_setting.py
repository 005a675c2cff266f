"""A new setting is one field: made here in a copy, by a diff."""

from functools import partial

import commands
import pytest

PROGRAM = """
import sys
from nlds_vines.__main__ import main
from nlds_vines.tuning.request import load_tuning
if sys.argv[1:]:
    sys.exit(main(sys.argv[1:]))
usual, other = load_tuning("tmd"), load_tuning({"system": "tmd", "search": {"patience": 7}})
assert other.search.patience == 7 and usual.search.patience == 20
assert "patience = 7" in other.to_toml() and "patience = 20" in usual.to_toml()
assert usual.hash != other.hash == load_tuning(other.document()).hash
"""


@pytest.fixture(scope="module")
def changed(tmp_path_factory):
    """Return a function that runs a changed copy of the package."""
    folder = commands.changed(tmp_path_factory.mktemp("changed"), "setting")
    return partial(commands.python, "-c", PROGRAM, cwd=folder, PYTHONPATH=str(folder))


def test_files_and_hashes_know_it(changed):
    done = changed()
    assert done.returncode == 0, done.stderr


def test_it_has_an_option_with_help_and_refusal(changed):
    assert (
        "generations without gain that end a search [20]" in changed("tuning", "--help-all").stdout
    )
    done = changed("tuning", "--patience", "0")
    assert done.returncode == 2
    assert done.stderr == (
        "nlds-vines tuning: error: command line: [search]: "
        "patience = 0 must be a whole number from 1 to 1000\n"
    )
