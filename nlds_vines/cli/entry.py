"""The first module of a program: a signal while it loads the others ends it in one line, too.

So this module, `nlds_vines/__init__.py` and `nlds_vines/__main__.py` import next to nothing.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from importlib import import_module


def run(work: Callable[[], int]) -> int:
    """Load what a program needs, run its `work` and return the exit status."""
    try:
        from nlds_vines.cli.terminal import exit_status_of
    except KeyboardInterrupt:  # nothing takes signals yet
        sys.stderr.write("nlds-vines: interrupted\n")
        status = 130
    else:
        status = exit_status_of("", work)
    # after Ctrl-C within `exec` of a text, as of a data class, Python would end by the signal
    # rather than with our status; the next evaluation of a text makes it forget that
    eval("0")
    return status


def run_module(name: str) -> int:
    """Run the `main` of a module with the arguments of the process; return the exit status."""
    return run(lambda: import_module(name).main())
