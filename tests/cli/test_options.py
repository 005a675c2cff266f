"""Options: how texts are read, which of them --help lists, and which exclude each other."""

import re
from importlib import import_module

import pytest

from nlds_vines.__main__ import COMMANDS
from nlds_vines.cli.options import Parser, comma_separated, ends, numbers_by_name, spaced


def test_ranges_and_lists(error_of):
    assert spaced("--vary P", "1:2.5:3") == {"start": 1.0, "stop": 2.5, "num": 3}
    assert spaced("--vary P", "1:10:3:log")["scale"] == "log"
    assert ends("--free k2", "1:2", "low", "high") == {"low": 1.0, "high": 2.0}
    assert comma_separated(" a,b ,, c") == ["a", "b", "c"]
    assert numbers_by_name("--at", "P=1,omega=2") == {"P": 1.0, "omega": 2.0}
    assert error_of(ends, "--free k2", "5", "low", "high") == "--free k2 = '5' must be LOW:HIGH"


def options_in(text):
    return set(re.findall(r"^  (?:-\w[^,]*, )?(--[a-z-]+)", text, re.MULTILINE))


@pytest.mark.parametrize("name", COMMANDS)
def test_help_lists_what_matters_and_help_all_the_rest(name, answer):
    command = import_module(COMMANDS[name][0]).main.__self__
    parser = Parser()
    command.declare(parser)
    declared = {action.option_strings[-1] for action in parser._actions if action.option_strings}
    common = set(command.common.split())
    assert common <= declared
    assert len(common) in (0, 8)
    assert common or len(declared) < 24
    short = options_in(answer(name, "--help"))
    assert short - {"--help", "--help-all"} == (common or declared - {"--help"})
    if common:
        assert options_in(answer(name, "--help-all")) >= declared


def test_two_options_for_one_entry_are_refused(here, refusal):
    line = refusal("tuning", "--band", "5:8:3", "--over", "omega=5,6")
    assert "--over and the option before it that gives omega exclude each other" in line
    assert "--all and" in refusal("continuation", "--from", "rest", "--all")
