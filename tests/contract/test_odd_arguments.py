"""Arguments that no one means: one line and status 2, whatever the command."""

from importlib import import_module

import pytest
from made_up import make_scan, write

from nlds_vines.cli.commands import COMMANDS
from nlds_vines.cli.parser import Parser


def values_of(name):
    """Return the options of a command that take a value."""
    parser = Parser(prog=name)
    module = import_module(COMMANDS[name][0])
    getattr(module, "COMMAND", None) or pytest.skip("its options depend on the first one")
    module.COMMAND.declare(parser)
    return [a.option_strings[-1] for a in parser._actions if a.option_strings and a.nargs != 0]


@pytest.mark.parametrize("name", COMMANDS)
def test_two_dashes_are_no_value_of_an_option(name, refusal):
    for option in values_of(name):
        assert refusal(name, f"{option}=--").endswith(
            f"{option}: expected one argument, not '--'\n"
        )


@pytest.mark.parametrize("argument", ["-o--", "-o=--"])
def test_nor_of_a_short_one(argument, refusal):
    assert refusal("bifurcation", argument).endswith("-o: expected one argument, not '--'\n")


@pytest.mark.parametrize("path", ["", ".", "/"])
@pytest.mark.parametrize(
    "words",
    [["plot"], ["export"], ["transients", "--dry-run", "-o"]],
    ids=lambda words: words[0],
)
def test_a_path_without_a_name_is_refused(words, path, refusal):
    assert f"{path!r} is no name of a file" in refusal(*words, path)


@pytest.mark.parametrize("style", ["/dev/zero", "large.mplstyle", ".", "no.mplstyle"])
def test_a_style_sheet_is_a_small_file(style, here, refusal):
    write(here / "scan.h5", make_scan())
    (here / "large.mplstyle").write_text("#" * 2_000_000)
    assert f"style {style!r} is no file" in refusal("plot", "scan.h5", "--style", style)
