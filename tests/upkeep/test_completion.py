"""Completion in a shell, and an archive as comma-separated values, by command."""

import csv
import io
import shutil
import subprocess

import pytest

import nlds_vines as nv
from nlds_vines.__main__ import COMMANDS, main
from nlds_vines.upkeep.completion import VALUES, options_of, script

TRY = """
COMP_WORDS=({words}); COMP_CWORD=$((${{#COMP_WORDS[@]}} - 1)); _nlds_vines
echo "${{COMPREPLY[@]}}"
"""


@pytest.fixture(scope="module")
def completed():
    """Return a function that returns what bash completes the last of some words to."""
    bash = shutil.which("bash")
    if bash is None:
        pytest.skip("bash is not installed")

    def complete(*words):
        given = " ".join(f"'{word}'" for word in ("nlds-vines", *words))
        done = subprocess.run(
            [bash, "--norc", "-uc", script() + TRY.format(words=given)],
            capture_output=True, text=True, check=True,
        )  # fmt: skip
        return done.stdout.split()

    return complete


def test_bash_completes_commands_options_and_names(completed):
    assert completed("bif") == ["bifurcation"]
    assert set(COMMANDS) <= set(completed(""))
    assert completed("bifurcation", "--sys") == ["--system"]
    assert completed("bifurcation", "--system", "ssul-set1") == ["ssul-set1"]
    assert completed("transients", "--effort", "th") == ["thorough"]
    assert completed("compile", "ssv") == ["ssvi-b", "ssvi-c"]
    assert completed("portrait", "figure") == []  # then bash looks for files


def test_words_between_commas_are_completed(completed):
    assert completed("bifurcation", "--record", "section,ene") == ["section,energy"]


@pytest.mark.parametrize("name", COMMANDS)
def test_every_option_of_every_command_is_known(completed, name):
    module, _ = COMMANDS[name]
    own = [option for option in options_of(module) if option.startswith("--")]
    assert "--help" in own
    assert completed(name, "--") == own


def test_the_options_with_words_are_options():
    known = {option for module, _ in COMMANDS.values() for option in options_of(module)}
    assert set(VALUES) <= known


def test_the_command_prints_it(answer):
    assert answer("completion") == script() + "\n"


@pytest.mark.kernels
def test_an_archive_is_exported(here, answer, refusal):
    scan = {
        "system": "none",
        "vary": {"omega": {"values": [6.0, 6.5]}},
        "sampling": {"transient": 1, "periods": 3},
        "record": {"want": ["section", "energy"]},
    }
    nv.scan(scan, to="a.h5", quiet=True)
    assert answer("export", "a.h5") == "a.csv\n"
    (first, _) = csv.DictReader(io.StringIO((here / "a.csv").read_text()))
    assert float(first["E1max"]) == nv.read("a.h5")["E1max"][0, 0]
    assert "'a.csv' exists: --overwrite" in refusal("export", "a.h5")
    assert main(["export", "a.h5", "section", "-o", "b.csv", "--quiet"]) == 0
    assert (here / "b.csv").read_text().splitlines()[0] == "omega,start,cycle,x1,v1"
    for wrong, words in (
        (["nothing"], "unknown dataset"),
        (["-o", "b.h5"], "must end in .csv"),
        (["-o", "no/b.csv"], "there is no folder"),
    ):
        assert words in refusal("export", "a.h5", *wrong, "--overwrite")
