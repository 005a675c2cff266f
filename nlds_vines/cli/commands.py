"""The names of all commands: where each is, and what it is for."""

from __future__ import annotations

USUAL = {
    "bifurcation": ("nlds_vines.bifurcation.command", "scan one parameter or two"),
    "response-curves": (
        "nlds_vines.bifurcation.response_curves.command",
        "dampers compared: energies against frequency",
    ),
    "portrait": ("nlds_vines.portrait.command", "one orbit in full"),
    "continuation": (
        "nlds_vines.continuation.command",
        "branches of periodic orbits, and what changes them",
    ),
    "tuning": ("nlds_vines.tuning.command", "search for the best damper"),
    "transients": ("nlds_vines.transients.command", "how long chaos lasts, where starts end"),
    "response-history": ("nlds_vines.loads.command", "a blow: how energy falls, and where it goes"),
    "explore": ("nlds_vines.explore.command", "click a map and see its orbit, in a browser"),
    "plot": ("nlds_vines.upkeep.plot", "draw a finished archive"),
}
"""What most people need."""

UPKEEP = {
    "rerun": ("nlds_vines.upkeep.rerun", "repeat a scan from its own archive"),
    "export": ("nlds_vines.upkeep.export", "an archive as comma-separated values"),
    "report": ("nlds_vines.explore.report.command", "a map as one page to send"),
    "accuracy": ("nlds_vines.accuracy.command", "error against run time of every method"),
}
"""What looks after archives and the program itself."""

COMMANDS = USUAL | UPKEEP
"""All sister commands: the module of each, whose `main` takes the arguments, and its purpose."""
