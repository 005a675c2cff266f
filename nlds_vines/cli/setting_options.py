"""The same as `cli.options`."""

import argparse
from typing import Any

from nlds_vines.cli.command import changes
from nlds_vines.cli.options import add_settings as add_settings


def changed(options: argparse.Namespace, *owners: Any) -> dict[str, dict[str, Any]]:
    """Return the document of what options change in a request file."""
    return changes(options, (), owners)
