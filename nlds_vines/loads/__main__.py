"""`python -m nlds_vines.loads`."""

from nlds_vines.cli.entry import run_module

raise SystemExit(run_module("nlds_vines.loads.command"))
