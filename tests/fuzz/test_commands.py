"""A thousand command lines that no one means."""

import random
from importlib import import_module

import pytest
from contract.made_up import MAP, make_scan, write
from fuzz.rule import CASES, STRANGE, broken_by, command, short

from nlds_vines.cli.commands import COMMANDS
from nlds_vines.cli.parser import Parser

pytestmark = pytest.mark.long

USUAL = {
    "report": ["a.h5", "-o", "p.html"],
    "rerun": ["a.h5", "-o", "r.h5", "--dry-run"],
    "export": ["a.h5", "-o", "c.csv"],
    "plot": ["a.h5", "--show", "?"], "explore": ["a.h5", "--port", "0", "--dry-run"],
}  # fmt: skip
"""Words with which a command computes nothing, where these are not `--dry-run` alone."""


def options_of(name):
    """Return the options of a command."""
    found = getattr(import_module(COMMANDS[name][0]), "COMMAND", None)
    parser = Parser(prog=name)
    if found is not None:
        found.declare(parser)
    return [action for action in parser._actions if "--help" not in action.option_strings]


def test_no_command_line_breaks_the_rule(here):
    write(here / "a.h5", make_scan(("energy", "regime"), vary=MAP))
    rng, wrong = random.Random(1), []
    names = sorted(COMMANDS)
    for number in range(CASES):
        name = rng.choice(names)
        words = list(USUAL.get(name, ["--dry-run"]))
        for action in rng.choices(options_of(name) or [None], k=rng.randint(1, 3)):
            value = rng.choice(STRANGE)
            if action is None or not action.option_strings:
                words.insert(0, value)
            elif action.nargs == 0:
                words.append(rng.choice([action.option_strings[-1], f"--{value}"]))
            else:
                option = action.option_strings[-1]
                words += rng.choice([[option, value], [f"{option}={value}"]])
        if found := broken_by(command([name, *words]), here):
            wrong.append(f"case {number}: {name} {short(words)}: {found}")
        for path in here.iterdir():
            if path.name != "a.h5":
                path.unlink()
    assert not wrong, "\n".join(wrong)
