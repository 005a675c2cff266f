"""A command's way from arguments to exit status: every error is one line."""

import pytest

from nlds_vines.cli.command import Command
from nlds_vines.errors import RequestError
from nlds_vines.runs.interrupts import Interrupted


def command(carry_out):
    return Command(
        name="test",
        description="A test.",
        examples="examples: none",
        declare=lambda parser: parser.add_argument("--number", type=int),
        carry_out=carry_out,
    )


def raising(error):
    def carry_out(options):
        raise error

    return carry_out


def test_options_arrive_and_the_status_is_returned():
    seen = []
    assert command(lambda options: seen.append(options) or 1).main(["--number", "3"]) == 1
    (options,) = seen
    assert options.number == 3
    assert options.argv == ["--number", "3"]


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
def test_what_ends_a_command_is_one_line(error, status, message, capsys):
    assert command(raising(error)).main([]) == status
    out, err = capsys.readouterr()
    assert out == ""
    assert err == f"nlds-vines test: {message}\n"


def test_help_names_description_and_examples(capsys):
    assert command(raising(AssertionError())).main(["--help"]) == 0
    text = capsys.readouterr().out
    assert "usage: nlds-vines test" in text
    assert "A test." in text
    assert "examples: none" in text
