"""The console script `nlds-vines COMMAND ...`, and `python -m nlds_vines`."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from importlib import import_module

from nlds_vines.cli.entry import run

USUAL = {
    "bifurcation": ("nlds_vines.bifurcation.command", "scan one parameter or two"),
    "response-curves": (
        "nlds_vines.bifurcation.curves_command",
        "dampers compared: energies against frequency",
    ),
    "portrait": ("nlds_vines.portrait.command", "one orbit in full"),
    "continuation": (
        "nlds_vines.continuation.command",
        "branches of periodic orbits, and what changes them",
    ),
    "tuning": ("nlds_vines.tuning.command", "search for the best damper"),
    "transients": ("nlds_vines.transients.command", "how long chaos lasts, where starts end"),
    "response-history": ("nlds_vines.loads.command", "a blow or an earthquake: energies, peaks"),
    "explore": ("nlds_vines.upkeep.explore", "click a map and see its orbit, in a browser"),
    "plot": ("nlds_vines.upkeep.plot", "draw a finished archive"),
}
"""What most people need."""

UPKEEP = {
    "rerun": ("nlds_vines.upkeep.rerun", "repeat a scan from its own archive"),
    "export": ("nlds_vines.upkeep.export", "an archive as comma-separated values"),
    "report": ("nlds_vines.upkeep.report", "a map as one page to send"),
    "accuracy": ("nlds_vines.accuracy.command", "error against run time of every method"),
}
"""What looks after archives and the program itself."""

COMMANDS = USUAL | UPKEEP
"""All sister commands: the module of each, whose `main` takes the arguments, and its purpose."""

_HELP = """\
usage: nlds-vines COMMAND ... | --help | --version

Bifurcation and chaos analysis of vibro-impact nonlinear energy sinks.

commands (each has its own --help with examples):
{tasks}

archives, and the program itself:
{upkeep}

example:
  nlds-vines bifurcation --dry-run
"""


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command that the first of the arguments names; return its exit status."""
    arguments = list(sys.argv[1:] if argv is None else argv)

    def work() -> int:  # what a command needs is loaded here
        from nlds_vines.cli.terminal import DONE, WRONG_REQUEST, complain, say
        from nlds_vines.errors import unknown

        name = arguments[0] if arguments else "--help"
        if name in COMMANDS:
            module, _ = COMMANDS[name]
            return import_module(module).main(arguments[1:])
        if name in ("-h", "--help"):
            tasks, upkeep = (
                "\n".join(f"  {name:<17}{purpose}" for name, (_, purpose) in commands.items())
                for commands in (USUAL, UPKEEP)
            )
            say(*_HELP.format(tasks=tasks, upkeep=upkeep).splitlines())
            return DONE
        if name == "--version":
            from nlds_vines.archives.provenance import version

            say(f"nlds-vines {version('nlds-vines')}")
            return DONE
        complain("", f"error: {unknown('command', name, COMMANDS)}")
        return WRONG_REQUEST

    status = run(work)
    if argv is None:  # this process is the command
        from nlds_vines.runs.interrupts import end_with

        end_with(status)
    return status


if __name__ == "__main__":
    sys.exit(main())
