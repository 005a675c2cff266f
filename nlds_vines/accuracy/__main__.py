"""`python -m nlds_vines.accuracy`."""

from nlds_vines.cli.entry import run_module

raise SystemExit(run_module("nlds_vines.accuracy.command"))
