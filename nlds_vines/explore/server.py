"""The local server of a page: bound to this machine, behind a token, ended by Ctrl-C.

The address that is printed has a token for its path.  It answers with a cookie that holds the token
and leads to the page, whose address has none: it is in no history and no picture of the screen.
Every other request must bring the cookie; every request must name this server as its host, and,
where it comes from a page, this server as its origin.  Anything else is refused before it reaches
Bokeh.
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
from tornado.httputil import HTTPHeaders, HTTPServerRequest
from tornado.ioloop import IOLoop
from tornado.web import OutputTransform, RequestHandler

from nlds_vines.explore.local_port import ADDRESS
from nlds_vines.runs.interrupts import INTERRUPTED, TERMINATED

LEFT_SECONDS = 2.0
"""Seconds after which a page that was closed counts as left, and its work ends."""


MOST_PAGES = 12
"""Pages that may be open at a time: each takes half a second to make, and memory."""


class Refused(RequestHandler):
    """The answer to a request that is not allowed."""

    def initialize(self, status: int, text: str) -> None:
        """Take the status and the reason."""
        self._answer = status, text

    def prepare(self) -> None:
        """Answer at once, whatever the method."""
        status, text = self._answer
        self.set_status(status)
        self.set_header("Content-Type", "text/plain; charset=utf-8")
        self.finish(f"refused: {text}\n")


class Entry(RequestHandler):
    """The answer at the address with the token: the token as a cookie, and the way to the page."""

    def initialize(self, name: str, token: str) -> None:
        """Take the name of the cookie, and the token."""
        self._cookie = name, token

    def get(self) -> None:
        """Answer."""
        name, token = self._cookie
        self.set_cookie(name, token, httponly=True, samesite="Lax", path="/")
        self.redirect("/")


class Headers(OutputTransform):
    """What every answer tells a browser: to load nothing from elsewhere, to show it in no frame."""

    def transform_first_chunk(
        self, status_code: int, headers: HTTPHeaders, chunk: bytes, finishing: bool
    ) -> tuple[int, HTTPHeaders, bytes]:
        """Add the headers to an answer."""
        for name, value in _HEADERS.items():
            headers[name] = value
        return status_code, headers, chunk


_HEADERS = {
    "Content-Security-Policy": "default-src 'none'; connect-src 'self'; img-src 'self' data: blob:;"
    " script-src 'self' 'unsafe-inline' 'unsafe-eval'; style-src 'self' 'unsafe-inline';"
    " base-uri 'none'; form-action 'none'; frame-ancestors 'none'",
    "X-Frame-Options": "DENY",
    "X-Content-Type-Options": "nosniff",
    "Referrer-Policy": "no-referrer",
}
"""Headers of every answer; Bokeh makes functions of texts, which a policy calls `unsafe-eval`."""


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
        """Take the `host`, address and port, and the `token` of the address that is printed."""
        self._host, self._token = host, token
        self._cookie = f"nlds_vines_{host.rpartition(':')[2]}"  # ports share their cookies
        super().__init__(
            applications,
            extra_websocket_origins=[host],
            absolute_url=f"http://{host}",
            ico_path="none",
            check_unused_sessions_milliseconds=500,
            unused_session_lifetime_milliseconds=int(1000 * LEFT_SECONDS),
        )
        self.transforms.append(Headers)

    def resources(self, absolute_url: str | bool | None = None) -> Resources:
        """Return the scripts of the page: figures alone, no tables, formulae or controls."""
        found = super().resources(absolute_url)
        found.components = ["bokeh"]
        return found

    def find_handler(self, request: HTTPServerRequest, **settings: Any) -> Any:
        """Return Bokeh's handler of a request that is allowed, or what answers it at once."""
        answer: tuple[Any, dict[str, Any]] | None = None
        if not self._is_ours(request) or "%00" in request.path:
            answer = Refused, {"status": 403, "text": _ADDRESS}
        elif self._names_token(request):
            answer = Entry, {"name": self._cookie, "token": self._token}
        elif not self._brings_token(request):
            answer = Refused, {"status": 403, "text": _ADDRESS}
        elif request.path == "/" and len(self.get_sessions("/")) >= MOST_PAGES:
            answer = Refused, {"status": 503, "text": _CROWDED}
        if answer is None:
            return super().find_handler(request, **settings)
        return self.get_handler_delegate(request, *answer)

    def get_handler_delegate(
        self, request: HTTPServerRequest, target_class: Any, *others: Any, **more: Any
    ) -> Any:
        """Return what handles a request; connections with pages are prompt."""
        chosen = PromptSocket if target_class is WSHandler else target_class
        return super().get_handler_delegate(request, chosen, *others, **more)

    def _is_ours(self, request: HTTPServerRequest) -> bool:
        """Return whether a request names host and, if any, origin as it must."""
        origins = [
            *request.headers.get_list("Origin"),
            *request.headers.get_list("Sec-Websocket-Origin"),
        ]
        return request.headers.get_list("Host") == [self._host] and all(
            origin == f"http://{self._host}" for origin in origins
        )

    def _names_token(self, request: HTTPServerRequest) -> bool:
        """Return whether the path of a request is the token."""
        return hmac.compare_digest(request.path.strip("/").encode(), self._token.encode())

    def _brings_token(self, request: HTTPServerRequest) -> bool:
        """Return whether a request has the token among its cookies."""
        found = request.cookies.get(self._cookie)
        return found is not None and hmac.compare_digest(found.value.encode(), self._token.encode())


_ADDRESS = "open the address that nlds-vines explore has printed"
_CROWDED = f"{MOST_PAGES} pages are open, which is the most; close one and load this one again"


class PageServer:
    """A server of one page on this machine."""

    def __init__(self, fill: Callable[[Document], object], listening: socket.socket) -> None:
        """Take the socket of `local_port.listening`; `fill` fills the document of a new page."""
        for name in ("bokeh", "tornado"):  # what a page asks wrongly, the page is told
            logging.getLogger(name).setLevel(logging.CRITICAL)
        self.port = int(listening.getsockname()[1])
        self.token = secrets.token_urlsafe(24)
        self._loop = IOLoop.current()
        self._fill = fill
        application = Application(FunctionHandler(self._open))
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

    def _open(self, document: Document) -> None:
        """Fill the document of a new page, unless the server is about to end."""
        if not self._status:
            self._fill(document)

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
