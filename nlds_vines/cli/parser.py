"""The same as `cli.options`."""

from nlds_vines.cli.options import Parser as Parser
