"""Click a map and see its orbit: a local page of an archive, a scan or a system.

As a command: `python -m nlds_vines.explore`, or `nlds-vines explore`.
"""

from __future__ import annotations

import argparse
from collections.abc import Mapping
from contextlib import closing
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Any

from nlds_vines.bifurcation.request import load_scan
from nlds_vines.cli.command import Command, changes
from nlds_vines.cli.options import SET, SYSTEM, Parser
from nlds_vines.cli.running import RunOptions
from nlds_vines.cli.terminal import DONE, say
from nlds_vines.errors import RequestError, shown, whole
from nlds_vines.explore.local_port import PORT, listening
from nlds_vines.model.system import System
from nlds_vines.runs.interrupts import exit_without_destructors

if TYPE_CHECKING:
    import socket

    from nlds_vines.bifurcation.request import Scan
    from nlds_vines.explore.map_data import Stored
    from nlds_vines.explore.shared_map import Opened

_NAME = "explore"
_CELLS = 401  # of the diagram of a system that is named alone
_WINDOW = (0.7, 1.3)  # of its frequencies, in natural frequencies of the structure
_EXAMPLES = """\
examples:
  nlds-vines explore
      Figure 8 of the paper, computed now: click a frequency and see its orbit
  nlds-vines explore map.h5
      the map of an archive; the arrow keys go from cell to cell
  nlds-vines explore scans/map-omega-P.toml
      a map that is computed while one looks at it
  nlds-vines explore --system vi-nes --port 0 --no-browser
      a system of the catalog, on a port that is free; the address is printed
The page is served to this machine alone; Ctrl-C ends it.  Needs the extra `explore`:
pip install 'nlds-vines[explore]'
exit status: 130 after Ctrl-C, 143 terminated; 2 the request is wrong, or the port is taken
"""


def _carry_out(options: argparse.Namespace) -> int:
    port = whole("--port", options.port, 0, 65535)
    source = None if options.source is None else Path(options.source)
    archived = source is not None and source.suffix.lower() != ".toml"
    if archived and (options.system is not None or options.set):
        raise RequestError(
            f"--system and --set beside {shown(str(source))}: an archive has its system; "
            "the page has a slider for every parameter"
        )
    scan = None if archived else _scan(source, changes(options, (SYSTEM, SET), ()))
    refuse_without_bokeh(_NAME)
    RunOptions()  # refuses an environment in which no kernel can be loaded
    found = None
    if archived:
        from nlds_vines.explore.map_data import stored

        assert source is not None
        found = stored(source)
    if options.dry_run:
        listening(port).close()
        say(_described(scan if found is None else found.scan))
        return DONE
    return _serve(found, scan, port, not options.no_browser)


def refuse_without_bokeh(command: str) -> None:
    """Raise `RequestError` where Bokeh is not installed."""
    if find_spec("bokeh") is None:
        raise RequestError(
            f"{command} needs Bokeh: python -m pip install 'nlds-vines[explore]' installs it"
        )


def _scan(source: Path | None, changes: Mapping[str, Any]) -> Scan:
    """Return the scan of a file, of a system that is named alone, or of Figure 8."""
    if source is None and isinstance(changes.get("system"), System):
        return _diagram_of(changes)
    return load_scan(source, changes, "command line")


def _diagram_of(changes: Mapping[str, Any]) -> Scan:
    """Return the diagram of a system around the natural frequency of its structure."""
    system: System = changes["system"].with_(**changes.get("set", {}))
    m1, k1, _ = system.structure
    center = (k1 / m1) ** 0.5 if k1 > 0 else system.parameters["omega"]
    low, high = (factor * center for factor in _WINDOW)
    vary = {"omega": {"start": low, "stop": high, "num": _CELLS}}
    document = {"system": system.to_table(), "vary": vary, "title": system.title or system.name}
    return load_scan({**document, "start": {"policy": "rest"}})


def _described(scan: Scan | None) -> str:
    assert scan is not None
    sides = " x ".join(str(n) for n in scan.shape)
    varied = ", ".join(axis.name for axis in scan.axes)
    return f"{scan.title}: {varied}, {sides} cells, {scan.starts} starts each"


def _serve(found: Stored | None, scan: Scan | None, port: int, browser: bool) -> int:
    """Serve the page of an archive or of a scan until it is ended; return the exit status.

    Performance: the kernels are loaded while Bokeh is imported.
    """
    with closing(listening(port)) as place:
        from nlds_vines.explore.shared_map import Opened

        opened = Opened(found, scan)
        opened.begin()
        try:
            return _served(opened, place, browser)
        finally:
            if not opened.close():
                exit_without_destructors()


def _served(opened: Opened, place: socket.socket, browser: bool) -> int:
    from nlds_vines.explore.live_page import Page
    from nlds_vines.explore.page_server import PageServer

    server = PageServer(lambda document: Page(document, opened), place)
    say(
        opened.found.scan.title,
        f"open {server.address}",
        "Ctrl-C ends it; what it computes is not kept",
    )
    return server.serve(browser)


def _declare(parser: Parser) -> None:
    add = parser.add_argument
    add("source", nargs="?", metavar="FILE.h5|SCAN.toml", help="by default Figure 8, computed now")
    for option in (SYSTEM, SET):
        option.add(parser)
    add("--port", type=int, default=PORT, metavar="N", help=f"[{PORT}]; 0: one that is free")
    add("--no-browser", action="store_true", help="only print the address")
    add("--dry-run", action="store_true", help="only say what would be shown")


COMMAND = Command(
    name=_NAME,
    description="Click a map and see its orbit: a local page in the browser.",
    examples=_EXAMPLES,
    declare=_declare,
    carry_out=_carry_out,
)
main = COMMAND.main
