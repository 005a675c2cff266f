"""`python -m nlds_vines.explore`."""

from nlds_vines.cli.entry import run_module

raise SystemExit(run_module("nlds_vines.upkeep.explore"))
