"""Options, and a command's way from arguments to exit status: every error is one line."""

import re
from importlib import import_module
from unittest.mock import Mock

import pytest

from nlds_vines.__main__ import COMMANDS
from nlds_vines.cli.command import Command
from nlds_vines.cli.options import Parser, comma_separated, ends, numbers_by_name, spaced
from nlds_vines.errors import RequestError
from nlds_vines.runs.interrupts import Interrupted


def test_ranges_and_lists(error_of):
    assert spaced("--vary P", "1:2.5:3") == {"start": 1.0, "stop": 2.5, "num": 3}
    assert spaced("--vary P", "1:10:3:log")["scale"] == "log"
    assert ends("--free k2", "1:2", "low", "high") == {"low": 1.0, "high": 2.0}
    assert comma_separated(" a,b ,, c") == ["a", "b", "c"]
    assert numbers_by_name("--at", "P=1,omega=2") == {"P": 1.0, "omega": 2.0}
    assert error_of(ends, "--free k2", "5", "low", "high") == "--free k2 = '5' must be LOW:HIGH"


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
    listed = re.compile(r"^  (?:-\w[^,]*, )?(--[a-z-]+)", re.MULTILINE)
    short = {*listed.findall(answer(name, "--help"))}
    assert short - {"--help", "--help-all"} == (common or declared - {"--help"})
    if common:
        assert {*listed.findall(answer(name, "--help-all"))} >= declared


@pytest.fixture
def command():
    return Command(
        name="test", description="A test.", examples="examples: none", carry_out=Mock(),
        declare=lambda parser: parser.add_argument("--number", type=int),
    )  # fmt: skip


def test_options_arrive_and_the_status_is_returned(command):
    command.carry_out.return_value = 1
    assert command.main(["--number", "3"]) == 1
    (options,) = command.carry_out.call_args.args
    assert options.number == 3


@pytest.mark.parametrize(
    ("error", "status", "message"),
    [
        (RequestError("wrong"), 2, "error: wrong"),
        (OSError(28, "No space left on device", "a.h5"), 2, "error: a.h5: No space left on device"),
        (OSError("over\nmany\nlines"), 2, "error: over many lines"),
        (PermissionError(), 2, "error: PermissionError"),
        (Interrupted("goes on with --resume", 143), 143, "goes on with --resume"),
        (KeyboardInterrupt(), 130, "interrupted"),
    ],
)
def test_what_ends_a_command_is_one_line(error, status, message, command, capsys):
    command.carry_out.side_effect = error
    assert command.main([]) == status
    out, err = capsys.readouterr()
    assert out == ""
    assert err == f"nlds-vines test: {message}\n"


def test_help_names_description_and_examples(command, capsys):
    assert command.main(["--help"]) == 0
    command.carry_out.assert_not_called()
    text = capsys.readouterr().out
    assert "usage: nlds-vines test" in text
    assert "A test." in text
    assert "examples: none" in text
