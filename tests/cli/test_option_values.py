"""The values of options that commands share: what they mean, and one line where they mean none."""

import argparse

import pytest

from nlds_vines.cli.option_values import (
    add_system_options,
    chosen_system,
    comma_separated,
    given,
    interval,
    spaced,
    system_changes,
)
from nlds_vines.cli.parser import Parser
from nlds_vines.errors import RequestError


def options(*arguments: str) -> argparse.Namespace:
    parser = Parser()
    add_system_options(parser)
    return parser.parse_args(list(arguments))


def test_ranges_and_lists():
    assert spaced("--vary P", "1:2.5:3") == {"start": 1.0, "stop": 2.5, "num": 3}
    assert interval("--free k2", "1:2") == {"low": 1.0, "high": 2.0}
    assert comma_separated(" a,b ,, c") == ["a", "b", "c"]
    assert comma_separated(None) is None
    assert given({"a": None, "b": 0}) == {"b": 0}


def test_system_and_settings():
    asked = options("--system", "tmd", "--set", "P=600", "--set", "omega=7")
    assert chosen_system(asked, "ssbl").kind == "tmd"
    assert chosen_system(asked, "ssbl").parameters["P"] == 600.0
    found = system_changes(asked)
    assert found["system"].kind == "tmd"
    assert found["set"] == {"P": 600.0, "omega": 7.0}
    assert system_changes(options()) == {}
    assert chosen_system(options(), "ssbl").kind == "ssbl"
    with pytest.raises(RequestError, match=r"^--set: unknown parameter 'mass'"):
        chosen_system(options("--set", "mass=1"), "tmd")
