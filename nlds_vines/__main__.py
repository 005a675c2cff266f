"""The console script `nlds-vines COMMAND ...`, and `python -m nlds_vines`."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from importlib import import_module

from nlds_vines.archives.provenance import version
from nlds_vines.cli.running import DONE, WRONG_REQUEST, complain
from nlds_vines.errors import unknown

COMMANDS = {
    "bifurcation": ("nlds_vines.bifurcation.command", "scan one parameter or two"),
    "transients": ("nlds_vines.transients.command", "how long chaos lasts, where starts end"),
    "tuning": ("nlds_vines.tuning.command", "search for the best damper"),
    "portrait": ("nlds_vines.portrait.command", "one orbit in full"),
    "continuation": (
        "nlds_vines.continuation.command",
        "branches of periodic orbits, and what changes them",
    ),
    "explore": ("nlds_vines.explore.command", "click a map and see its orbit, in a browser"),
    "report": ("nlds_vines.explore.report.command", "a map as one page to send"),
    "reproduce": (
        "nlds_vines.reproduce.command",
        "the paper: figures and claims",
    ),
    "accuracy": ("nlds_vines.accuracy.command", "error against run time of every method"),
    "status": ("nlds_vines.upkeep.status", "how a scan under way stands"),
    "consolidate": ("nlds_vines.upkeep.consolidate", "join the parts of shards into an archive"),
    "verify": ("nlds_vines.upkeep.verify", "check archives and parts from end to end"),
    "rerun": ("nlds_vines.upkeep.rerun", "repeat a scan from its own archive"),
    "diff": ("nlds_vines.upkeep.diff", "what differs between two archives"),
    "compile": ("nlds_vines.upkeep.compile", "compile kernels before runs need them"),
}
"""The sister commands: the module of each, whose `main` takes the arguments, and its purpose."""


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command that the first of the arguments names; returns its exit status."""
    arguments = list(sys.argv[1:] if argv is None else argv)
    name = arguments[0] if arguments else "--help"
    if name in COMMANDS:
        module, _ = COMMANDS[name]
        return import_module(module).main(arguments[1:])
    if name in ("-h", "--help"):
        print(_help())
        return DONE
    if name == "--version":
        print(f"nlds-vines {version('nlds-vines')}")
        return DONE
    complain("", f"error: {unknown('command', name, COMMANDS)}")
    return WRONG_REQUEST


def _help() -> str:
    lines = (f"  {name:<14}{purpose}" for name, (_, purpose) in COMMANDS.items())
    return "\n".join(
        [
            "usage: nlds-vines COMMAND ... | --help | --version",
            "",
            "Bifurcation and chaos analysis of vibro-impact nonlinear energy sinks.",
            "",
            "commands (each has its own --help with examples):",
            *lines,
            "",
            "example:",
            "  nlds-vines bifurcation --dry-run",
        ]
    )


if __name__ == "__main__":
    sys.exit(main())
