"""The server of the page: on this machine alone, behind a token, ended by Ctrl-C.

The printed address trades a random token for a cookie and redirects to the page, so that the token
stays out of the history and out of pictures of the screen.  Every other request must bring the
cookie, name this server as its host and, if it comes from a page, as its origin.
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

from nlds_vines.runs.interrupts import INTERRUPTED, TERMINATED

LEFT_SECONDS = 2.0
"""Seconds after a page is closed at which its work ends."""

MOST_PAGES = 12
"""The most open pages; each takes half a second to make, and memory."""

ENTRY = "/enter"

_ADDRESS = "open the address that nlds-vines explore has printed"
_CROWDED = f"{MOST_PAGES} pages are open, which is the most; close one and load this one again"

_HEADERS = {
    "Content-Security-Policy": "default-src 'none'; connect-src 'self'; img-src 'self' data: blob:;"
    " script-src 'self' 'unsafe-inline' 'unsafe-eval'; style-src 'self' 'unsafe-inline';"
    " base-uri 'none'; form-action 'none'; frame-ancestors 'none'",
    "X-Frame-Options": "DENY",
    "X-Content-Type-Options": "nosniff",
    "Referrer-Policy": "no-referrer",
}
"""Headers of every answer; Bokeh compiles functions from text, which needs `unsafe-eval`."""


class Headers(OutputTransform):
    """Adds `_HEADERS` to every answer."""

    def transform_first_chunk(self, status_code: int, headers: Any, *rest: Any) -> Any:
        headers.update(_HEADERS)
        return status_code, headers, rest[0]


class Refused(RequestHandler):
    """The answer to a refused request, whatever its method."""

    def initialize(self, status: int, words: str) -> None:
        """Take the status and the reason."""
        self._answer = status, words

    def prepare(self) -> None:
        status, words = self._answer
        self.set_status(status)
        self.set_header("Content-Type", "text/plain; charset=utf-8")
        self.finish(f"refused: {words}\n")


class Owner(AuthProvider):
    """Admits a browser that has opened the printed address."""

    login_url = ENTRY
    login_handler: Any = None
    get_user_async = get_login_url = logout_url = logout_handler = None

    def __init__(self, host: str) -> None:
        """Draw the token; the name of the cookie holds the port, since ports share cookies."""
        self.token = token = secrets.token_urlsafe(24)
        self.cookie = cookie = f"nlds_vines_{host.rpartition(':')[2]}"

        class Entry(RequestHandler):
            def get(self) -> None:
                self.set_cookie(cookie, token, httponly=True, samesite="Lax", path="/")
                self.redirect("/")

        self.login_handler = Entry
        super().__init__()

    def is_token(self, words: str) -> bool:
        """Return True for the token; the time that takes does not depend on `words`."""
        return hmac.compare_digest(words.encode(), self.token.encode())

    def brings_cookie(self, request: HTTPServerRequest) -> bool:
        """Return True if a request has the token in its cookie."""
        cookie = request.cookies.get(self.cookie)
        return cookie is not None and self.is_token(cookie.value)

    @property
    def get_user(self) -> Any:
        """The function that returns the user of a request, None for anybody but the owner."""
        return lambda handler: "owner" if self.brings_cookie(handler.request) else None


class OwnersServer(BokehTornado):
    """Bokeh's server behind a check of the cookie, the host and the origin of each request."""

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
        """Return the scripts of figures and widgets; the page has no tables and no formulas."""
        resources = super().resources(absolute_url)
        resources.components = ["bokeh", "bokeh-widgets"]
        return resources

    def find_handler(self, request: HTTPServerRequest, **settings: Any) -> Any:
        """Return Bokeh's handler of an admitted request, or else a refusal."""
        names = ("Origin", "Sec-Websocket-Origin")
        origins = [origin for name in names for origin in request.headers.get_list(name)]
        is_ours = request.headers.get_list("Host") == [self._host]
        is_ours = is_ours and set(origins) <= {f"http://{self._host}"}
        words = ""
        if not is_ours or "%00" in request.path:
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


class PageServer:
    """A server of one page on this machine."""

    def __init__(self, fill: Callable[[Document], object], listening: socket.socket) -> None:
        """Take a `listening` socket; `fill` fills the document of a new page."""
        for name in ("bokeh", "tornado"):  # a page shows its own errors
            logging.getLogger(name).setLevel(logging.CRITICAL)
        host = "{}:{}".format(*listening.getsockname())
        self._status, self._fill, self._loop = 0, fill, IOLoop.current()
        application = Application(FunctionHandler(self._open))
        owners = OwnersServer(application, host)
        self.address = f"http://{host}{ENTRY}?token={owners.owner.token}"
        http = HTTPServer(owners)
        http.add_socket(listening)
        self._server = BaseServer(self._loop, owners, http)

    def serve(self, browser: bool) -> int:
        """Serve until Ctrl-C or SIGTERM and return the exit status; open a `browser` or not."""
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
        """Fill the document of a new page, unless the server is ending."""
        if not self._status:
            self._fill(document)

    def _show(self) -> None:
        """Open a browser, in a thread, as one that runs in a terminal would block."""
        threading.Thread(target=webbrowser.open, args=(self.address,), daemon=True).start()

    def _handle(self, number: int, frame: object) -> None:
        self._status = INTERRUPTED if number == signal.SIGINT else TERMINATED
        self._loop.add_callback_from_signal(self._loop.stop)
