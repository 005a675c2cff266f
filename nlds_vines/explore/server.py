"""The local server of a page: bound to this machine, behind a token, ended by Ctrl-C.

Every request must name the token in its path, this server as its host, and, where it comes from a
page, this server as its origin.  Anything else is refused before it reaches Bokeh.
"""

from __future__ import annotations

import hmac
import logging
import secrets
import signal
import socket
import threading
import webbrowser
from collections.abc import Callable
from typing import Any

from bokeh.application import Application
from bokeh.application.handlers.function import FunctionHandler
from bokeh.document import Document
from bokeh.resources import Resources
from bokeh.server.server import BaseServer
from bokeh.server.tornado import BokehTornado
from bokeh.server.views.ws import WSHandler
from tornado.httpserver import HTTPServer
from tornado.httputil import HTTPServerRequest
from tornado.ioloop import IOLoop
from tornado.web import RequestHandler

from nlds_vines.explore.local_port import ADDRESS
from nlds_vines.runs.interrupts import INTERRUPTED, TERMINATED

LEFT_SECONDS = 2.0
"""Seconds after which a page that was closed counts as left, and its work ends."""


class Refused(RequestHandler):
    """The answer to a request that is not allowed."""

    def prepare(self) -> None:
        """Answer at once, whatever the method."""
        self.set_status(403)
        self.set_header("Content-Type", "text/plain; charset=utf-8")
        self.finish("refused: open the address that nlds-vines explore has printed\n")


class PromptSocket(WSHandler):
    """Bokeh's connection with a page, which sends at once.

    A page is told in several small messages.  None waits until the one before is confirmed, which
    takes 40 ms.
    """

    def open(self) -> None:
        """Open the connection."""
        self.set_nodelay(True)
        super().open()


class Gate(BokehTornado):
    """Bokeh's server, which only sees requests with the token, the host and the origin."""

    def __init__(self, applications: Any, host: str, token: str) -> None:
        """Take the `host`, address and port, and the `token` of all addresses."""
        self._host, self._first = host, token
        super().__init__(
            applications,
            prefix=token,
            extra_websocket_origins=[host],
            absolute_url=f"http://{host}",
            ico_path="none",
            check_unused_sessions_milliseconds=500,
            unused_session_lifetime_milliseconds=int(1000 * LEFT_SECONDS),
        )

    def resources(self, absolute_url: str | bool | None = None) -> Resources:
        """Return the scripts of the page: figures alone, no tables, formulae or controls."""
        found = super().resources(absolute_url)
        found.components = ["bokeh"]
        return found

    def find_handler(self, request: HTTPServerRequest, **settings: Any) -> Any:
        """Return Bokeh's handler of a request that is allowed, otherwise `Refused`."""
        if self.allows(request):
            return super().find_handler(request, **settings)
        return self.get_handler_delegate(request, Refused)

    def get_handler_delegate(
        self, request: HTTPServerRequest, target_class: Any, *others: Any, **more: Any
    ) -> Any:
        """Return what handles a request; connections with pages are prompt."""
        chosen = PromptSocket if target_class is WSHandler else target_class
        return super().get_handler_delegate(request, chosen, *others, **more)

    def allows(self, request: HTTPServerRequest) -> bool:
        """Return whether a request names host, token and, if any, origin as it must."""
        first = request.path.removeprefix("/").partition("/")[0]
        origins = [
            *request.headers.get_list("Origin"),
            *request.headers.get_list("Sec-Websocket-Origin"),
        ]
        return (
            hmac.compare_digest(first.encode(), self._first.encode())
            and request.headers.get_list("Host") == [self._host]
            and all(origin == f"http://{self._host}" for origin in origins)
        )


class PageServer:
    """A server of one page on this machine."""

    def __init__(self, fill: Callable[[Document], object], listening: socket.socket) -> None:
        """Take the socket of `local_port.listening`; `fill` fills the document of a new page."""
        logging.getLogger("bokeh").setLevel(logging.ERROR)
        logging.getLogger("tornado").setLevel(logging.ERROR)
        self.port = int(listening.getsockname()[1])
        self.token = secrets.token_urlsafe(24)
        self._loop = IOLoop.current()
        application = Application(FunctionHandler(fill))
        gate = Gate({"/": application}, f"{ADDRESS}:{self.port}", self.token)
        http = HTTPServer(gate)
        http.add_socket(listening)
        self._server = BaseServer(self._loop, gate, http)
        self._status = 0

    @property
    def address(self) -> str:
        """The address of the page."""
        return f"http://{ADDRESS}:{self.port}/{self.token}/"

    def serve(self, browser: bool) -> int:
        """Serve until Ctrl-C or SIGTERM; return the exit status that belongs to it.

        Arguments: whether a `browser` is told to show the page.
        """
        before = {
            number: signal.signal(number, self._handle)
            for number in (signal.SIGINT, signal.SIGTERM)
        }
        try:
            self._server.start()
            if browser:
                self._loop.call_later(0.1, self._show)
            self._loop.start()
        finally:
            self.stop()
            for number, handler in before.items():
                signal.signal(number, handler)
        return self._status

    def stop(self) -> None:
        """Close all connections and the port."""
        if not self._server._stopped:
            self._server.stop(wait=False)

    def _show(self) -> None:
        """Have a browser show the page; one that runs in a terminal holds nothing up."""
        threading.Thread(target=webbrowser.open, args=(self.address,), daemon=True).start()

    def _handle(self, number: int, frame: object) -> None:
        self._status = INTERRUPTED if number == signal.SIGINT else TERMINATED
        self._loop.add_callback_from_signal(self._loop.stop)
