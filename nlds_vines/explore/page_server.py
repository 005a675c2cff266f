"""The server of a page: on this machine alone, behind a token, ended by Ctrl-C.

The address that is printed trades a random token for a cookie and leads to the page, whose own
address has no token: it is in no history and on no picture of the screen.  Every other request must
bring that cookie, name this server as its host and, if it comes from a page, as its origin.
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
from bokeh.server.auth_provider import AuthProvider
from bokeh.server.server import BaseServer
from bokeh.server.tornado import BokehTornado
from tornado.httpserver import HTTPServer
from tornado.httputil import HTTPServerRequest
from tornado.ioloop import IOLoop
from tornado.web import OutputTransform, RequestHandler

from nlds_vines.explore.local_port import ADDRESS
from nlds_vines.runs.interrupts import INTERRUPTED, TERMINATED

LEFT_SECONDS = 2.0
"""Seconds after which a closed page counts as left, and its work ends."""

MOST_PAGES = 12
"""Pages that may be open at a time: each takes half a second to make, and memory."""

ENTRY = "/enter"

_HEADERS = {
    "Content-Security-Policy": "default-src 'none'; connect-src 'self'; img-src 'self' data: blob:;"
    " script-src 'self' 'unsafe-inline' 'unsafe-eval'; style-src 'self' 'unsafe-inline';"
    " base-uri 'none'; form-action 'none'; frame-ancestors 'none'",
    "X-Frame-Options": "DENY",
    "X-Content-Type-Options": "nosniff",
    "Referrer-Policy": "no-referrer",
}
"""Headers of every answer; Bokeh makes functions of texts, which a policy calls `unsafe-eval`."""


class Headers(OutputTransform):
    """Adds `_HEADERS` to every answer."""

    def transform_first_chunk(self, status_code: int, headers: Any, *rest: Any) -> Any:
        """Add the headers to an answer."""
        headers.update(_HEADERS)
        return status_code, headers, rest[0]


class Refused(RequestHandler):
    """The answer to a request that is not allowed, whatever its method."""

    def initialize(self, status: int, words: str) -> None:
        """Take the status and the reason."""
        self._answer = status, words

    def prepare(self) -> None:
        """Answer at once."""
        status, words = self._answer
        self.set_status(status)
        self.set_header("Content-Type", "text/plain; charset=utf-8")
        self.finish(f"refused: {words}\n")


class Owner(AuthProvider):
    """Lets in a browser that has opened the printed address."""

    def __init__(self, host: str) -> None:
        """Draw the token; the name of the cookie holds the port, since ports share cookies."""
        self.token = token = secrets.token_urlsafe(24)
        self.cookie = cookie = f"nlds_vines_{host.rpartition(':')[2]}"

        class Entry(RequestHandler):
            def get(self) -> None:
                self.set_cookie(cookie, token, httponly=True, samesite="Lax", path="/")
                self.redirect("/")

        self._entry = Entry
        super().__init__()

    def is_token(self, words: str) -> bool:
        """Return True for the token, in a time that tells nothing about it."""
        return hmac.compare_digest(words.encode(), self.token.encode())

    def brings_cookie(self, request: HTTPServerRequest) -> bool:
        """Return True if a request has the token among its cookies."""
        cookie = request.cookies.get(self.cookie)
        return cookie is not None and self.is_token(cookie.value)

    @property
    def get_user(self) -> Any:
        """The function that names the user of a request; None for anybody else."""
        return lambda handler: "owner" if self.brings_cookie(handler.request) else None

    @property
    def login_url(self) -> str:
        """The path at which the token becomes a cookie."""
        return ENTRY

    @property
    def login_handler(self) -> type[RequestHandler]:
        """The handler of that path."""
        return self._entry

    get_user_async = get_login_url = logout_url = logout_handler = None


class OwnersServer(BokehTornado):
    """Bokeh's server, which sees only requests of the owner, with this host and this origin."""

    def __init__(self, application: Application, host: str) -> None:
        """Take the `host`, address and port, under which the page is served."""
        self._host, self.owner = host, Owner(host)
        super().__init__(
            {"/": application},
            extra_websocket_origins=[host],
            absolute_url=f"http://{host}",
            ico_path="none",
            auth_provider=self.owner,
            sign_sessions=True,
            secret_key=secrets.token_bytes(32),
            check_unused_sessions_milliseconds=500,
            unused_session_lifetime_milliseconds=int(1000 * LEFT_SECONDS),
        )
        self.transforms.append(Headers)

    def resources(self, absolute_url: str | bool | None = None) -> Resources:
        """Return the scripts of the page: figures and widgets, no tables and no formulas."""
        resources = super().resources(absolute_url)
        resources.components = ["bokeh", "bokeh-widgets"]
        return resources

    def find_handler(self, request: HTTPServerRequest, **settings: Any) -> Any:
        """Return Bokeh's handler of a request that is allowed; refuse any other, files too."""
        words = ""
        if not self._is_ours(request) or "%00" in request.path:
            words = _ADDRESS
        elif request.path == ENTRY:
            token = request.arguments.get("token", [b""])[-1]
            words = "" if self.owner.is_token(token.decode("latin-1")) else _ADDRESS
        elif not self.owner.brings_cookie(request):
            words = _ADDRESS
        elif request.path == "/" and len(self.get_sessions("/")) >= MOST_PAGES:
            answer = {"status": 503, "words": _CROWDED}
            return self.get_handler_delegate(request, Refused, answer)
        if words:
            return self.get_handler_delegate(request, Refused, {"status": 403, "words": words})
        return super().find_handler(request, **settings)

    def _is_ours(self, request: HTTPServerRequest) -> bool:
        """Return True if a request names host and, if any, origin as it must."""
        names = ("Origin", "Sec-Websocket-Origin")
        origins = [origin for name in names for origin in request.headers.get_list(name)]
        is_host = request.headers.get_list("Host") == [self._host]
        return is_host and set(origins) <= {f"http://{self._host}"}


_ADDRESS = "open the address that nlds-vines explore has printed"
_CROWDED = f"{MOST_PAGES} pages are open, which is the most; close one and load this one again"


class PageServer:
    """A server of one page on this machine."""

    def __init__(self, fill: Callable[[Document], object], listening: socket.socket) -> None:
        """Take the socket of `local_port.listening`; `fill` fills the document of a new page."""
        for name in ("bokeh", "tornado"):  # a page shows its own errors
            logging.getLogger(name).setLevel(logging.CRITICAL)
        host = f"{ADDRESS}:{listening.getsockname()[1]}"
        self._status, self._fill, self._loop = 0, fill, IOLoop.current()
        application = Application(FunctionHandler(self._open))
        owners = OwnersServer(application, host)
        self.address = f"http://{host}{ENTRY}?token={owners.owner.token}"
        http = HTTPServer(owners)
        http.add_socket(listening)
        self._server = BaseServer(self._loop, owners, http)

    def serve(self, browser: bool) -> int:
        """Serve until Ctrl-C or SIGTERM; return the exit status that belongs to it.

        Arguments: `browser`, whether one is told to show the page.
        """
        signals = signal.SIGINT, signal.SIGTERM
        before = {number: signal.signal(number, self._handle) for number in signals}
        try:
            self._server.start()
            if browser:
                self._loop.call_later(0.1, self._show)
            self._loop.start()
        finally:
            self._server.stop(wait=False)
            for number, handler in before.items():
                signal.signal(number, handler)
        return self._status

    def _open(self, document: Document) -> None:
        """Fill the document of a new page, unless the server is about to end."""
        if not self._status:
            self._fill(document)

    def _show(self) -> None:
        """Have a browser show the page; one that runs in a terminal holds nothing up."""
        threading.Thread(target=webbrowser.open, args=(self.address,), daemon=True).start()

    def _handle(self, number: int, frame: object) -> None:
        self._status = INTERRUPTED if number == signal.SIGINT else TERMINATED
        self._loop.add_callback_from_signal(self._loop.stop)
