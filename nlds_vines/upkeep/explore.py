"""The command `nlds-vines explore`; Bokeh and the kernels are imported when the page is served."""

from __future__ import annotations

import argparse
import os
import socket
from contextlib import closing
from importlib.util import find_spec
from pathlib import Path

from nlds_vines.archives.archive import read
from nlds_vines.archives.provenance import SCAN
from nlds_vines.bifurcation.request import Scan, load_scan
from nlds_vines.cli.command import Command, changes
from nlds_vines.cli.options import FREQUENCY, SET, SYSTEM, Parser
from nlds_vines.cli.terminal import DONE, say
from nlds_vines.errors import RequestError, choice, shown, whole
from nlds_vines.model.ratios import UNITS
from nlds_vines.model.system import System
from nlds_vines.runs.executors import most_threads
from nlds_vines.runs.interrupts import exit_without_destructors

ADDRESS = "127.0.0.1"  # the only address at which the page is served
PORT = 5006  # the default port; 0 takes a free one

_CELLS = 401  # of the diagram of a system without a scan
_WINDOW = (0.7, 1.3)  # of its frequencies, in natural frequencies of the structure
_EXAMPLES = """\
examples:
  nlds-vines explore
      Figure 8 of the paper, computed now: click a frequency and see its orbit
  nlds-vines explore map.h5
      the map of an archive; the arrow keys go from cell to cell
  nlds-vines explore tuned.h5
      any other archive: what was asked, the systems drawn, tables and pictures
  nlds-vines explore scans/map-omega-P.toml
      a map that is computed while one looks at it
  nlds-vines explore --system vi-nes --port 0 --no-browser
      a system of the catalog, on a port that is free; the address is printed
The page is served to this machine alone; Ctrl-C ends it.  Needs the extra `explore`:
pip install 'nlds-vines[explore]'
exit status: 0 after --dry-run; 130 after Ctrl-C, 143 terminated; 2 the request is wrong, or the
port is taken
"""


def refuse_without_bokeh(command: str) -> None:
    if find_spec("bokeh") is None:
        raise RequestError(
            f"{command} needs Bokeh: python -m pip install 'nlds-vines[explore]' installs it"
        )


def holds_map(path: str | os.PathLike[str]) -> bool:
    """Return True if an archive holds a scan with axes, so that there is a cell to click."""
    from nlds_vines.bifurcation.result import scan_of

    with read(path) as view:
        return view.content == SCAN and scan_of(view).sampled is None


def _refuse_samples(scan: Scan) -> None:
    if scan.sampled is not None:
        raise RequestError(
            f"{scan.title}: samples have no axis, so there is no map to click; compute them with "
            "`nlds-vines bifurcation`, and open the archive"
        )


def listening(port: int) -> socket.socket:
    """Return a socket that listens on a port of this machine alone, unless the port is taken."""
    try:
        listener = socket.create_server((ADDRESS, port), backlog=64)
    except OSError as error:
        raise RequestError(
            f"--port {port} of {ADDRESS} cannot be used: {os.strerror(error.errno or 0)}; "
            "--port 0 takes one that is free"
        ) from None
    listener.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)  # connections inherit it
    listener.setblocking(False)
    return listener


def _carry_out(options: argparse.Namespace) -> int:
    port = whole("--port", options.port, 0, 65535)
    source = None if options.source is None else Path(options.source)
    is_archive = source is not None and source.suffix.lower() != ".toml"
    if is_archive and (options.system is not None or options.set):
        raise RequestError(
            f"--system and --set beside {shown(str(source))}: an archive has its system; "
            "the page has a slider for every parameter"
        )
    refuse_without_bokeh("explore")
    most_threads()  # refuses an environment in which no kernel can be loaded
    if options.frequency is not None:
        choice("--frequency", options.frequency, UNITS)
    document, results = changes(options, (SYSTEM, SET), ()), None
    if is_archive and not holds_map(options.source):
        return _serve_sent_page(options, Path(options.source), port)
    if is_archive:
        from nlds_vines.explore.map_data import stored

        results = stored(options.source, options.frequency)
        scan = results.scan
    elif source is None and isinstance(system := document.get("system"), System):
        # the diagram around the structure's natural frequency, or around omega if it has none
        system = system.with_(**document.get("set", {}))
        center = system.natural_frequency or system.parameters["omega"]
        low, high = (factor * center for factor in _WINDOW)
        vary = {"omega": {"start": low, "stop": high, "num": _CELLS}}
        document = {"system": system.to_table(), "vary": vary, "start": {"policy": "rest"}}
        scan = load_scan({**document, "title": system.title or system.name})
    else:
        scan = load_scan(source, document, "command line")
    _refuse_samples(scan)
    if options.dry_run:
        listening(port).close()
        sides = " x ".join(str(n) for n in scan.shape)
        varied = ", ".join(axis.heading() for axis in scan.axes)
        say(f"{scan.title}: {varied}; {sides} cells, {scan.starts} starts each")
        return DONE
    with closing(listening(port)) as listener:
        from nlds_vines.explore.page_state import Opened

        opened = Opened(results or scan, options.frequency)
        opened.begin()  # loads kernels while Bokeh is imported
        try:
            from nlds_vines.explore.live_page import Page
            from nlds_vines.explore.page_server import serve

            def greet(address: str) -> None:
                say(scan.title, f"open {address}", "Ctrl-C ends it; what it computes is not kept")

            return serve(
                lambda document: Page(document, opened), listener, greet, not options.no_browser
            )
        finally:
            if not opened.close():
                exit_without_destructors()


def _serve_sent_page(options: argparse.Namespace, source: Path, port: int) -> int:
    """Serve the page of an archive without a map, which `report` sends; it computes nothing."""
    if options.frequency is not None:
        raise RequestError(f"--frequency is for the page of a map; {source} has none")
    with read(source) as view:
        title = view.text("title")
    with closing(listening(port)) as listener:
        if options.dry_run:
            say(f"{title}: its page, as `nlds-vines report` sends it")
            return DONE
        from nlds_vines.explore.page_server import serve
        from nlds_vines.explore.sent_page import sent_page

        page = sent_page(source)

        def greet(address: str) -> None:
            say(title, f"open {address}", "Ctrl-C ends it")

        return serve(page, listener, greet, not options.no_browser)


def _declare(parser: Parser) -> None:
    add = parser.add_argument
    add("source", nargs="?", metavar="FILE.h5|SCAN.toml", help="by default Figure 8, computed now")
    for option in (SYSTEM, SET, FREQUENCY):
        option.add(parser)
    add("--port", type=int, default=PORT, metavar="N", help=f"[{PORT}]; 0: one that is free")
    add("--no-browser", action="store_true", help="only print the address")
    add("--dry-run", action="store_true", help="only say what would be shown")


main = Command(
    "explore",
    "Click a map and see its orbit: a local page in the browser.",
    _EXAMPLES,
    _declare,
    _carry_out,
).main
