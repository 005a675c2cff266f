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
import weakref
import webbrowser
from collections.abc import Callable
from typing import Any

from bokeh.application import Application
from bokeh.application.handlers.function import FunctionHandler
from bokeh.document import Document
from bokeh.resources import Resources
from bokeh.server.server import BaseServer
from bokeh.server.tornado import BokehTornado
from tornado.httpserver import HTTPServer
from tornado.httputil import HTTPServerRequest
from tornado.ioloop import IOLoop
from tornado.web import OutputTransform, RequestHandler

INTERRUPTED, TERMINATED = 130, 143  # the exit status after Ctrl-C and after SIGTERM
LEFT_SECONDS = 2.0  # seconds after a page is closed at which its work ends
MOST_PAGES = 12  # the most open pages; each takes half a second to make, and memory

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


Shown = Callable[[Document], object] | str
"""What pages show: what fills the document of each, or their text as HTML."""


def _leave_empty(document: Document) -> None:
    """Fill a document with nothing."""


class Headers(OutputTransform):
    def transform_first_chunk(self, status_code: int, headers: Any, *rest: Any) -> Any:
        headers.update(_HEADERS)
        return status_code, headers, rest[0]


class Answer(RequestHandler):
    """A refusal, or the way from the printed address to the page, whatever the method."""

    def initialize(self, status: int, words: str, **cookie: str) -> None:
        self._answer = status, words, cookie

    def prepare(self) -> None:
        status, words, cookie = self._answer
        if cookie:
            for name, value in cookie.items():
                self.set_cookie(name, value, httponly=True, samesite="Lax", path="/")
            self.redirect("/")
        else:
            self.set_status(status)
            self.set_header("Content-Type", "text/plain; charset=utf-8")
            self.finish(f"refused: {words}\n")


class TextPage(RequestHandler):
    """A page that is a text and computes nothing."""

    def initialize(self, html: str) -> None:
        self._html = html

    def get(self) -> None:
        self.set_header("Content-Type", "text/html; charset=utf-8")
        self.finish(self._html)


class OwnersServer(BokehTornado):
    """Bokeh's server behind a check of the cookie, the host and the origin of each request."""

    def __init__(self, shown: Shown, host: str) -> None:
        """Draw the token; the cookie is named by the port, as all ports of a host share cookies."""
        self._html = shown if isinstance(shown, str) else ""
        fill = _leave_empty if isinstance(shown, str) else shown
        self._host, self.token = host, secrets.token_urlsafe(24)
        self._cookie = f"nlds_vines_{host.rpartition(':')[2]}"
        # requests of pages that are not answered yet, whose sessions do not exist yet
        self._beginning: weakref.WeakSet[HTTPServerRequest] = weakref.WeakSet()
        super().__init__(
            {"/": Application(FunctionHandler(fill))},
            extra_websocket_origins=[host],
            absolute_url=f"http://{host}",
            ico_path="none",
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
        """Return Bokeh's handler of an admitted request, or else an `Answer`."""

        def is_token(words: str) -> bool:  # in a time that does not depend on the words
            return hmac.compare_digest(words.encode(), self.token.encode())

        names = ("Origin", "Sec-Websocket-Origin")
        origins = [origin for name in names for origin in request.headers.get_list(name)]
        is_ours = request.headers.get_list("Host") == [self._host] and "%00" not in request.path
        cookie, token = request.cookies.get(self._cookie), request.arguments.get("token", [b""])[-1]
        answer: dict[str, Any] = {"status": 403, "words": _ADDRESS}
        if is_ours and {*origins} <= {f"http://{self._host}"}:
            if request.path == ENTRY:
                answer |= {self._cookie: self.token} if is_token(token.decode("latin-1")) else {}
            elif cookie is not None and is_token(cookie.value):
                is_page = request.path == "/"
                if self._html and is_page:
                    return self.get_handler_delegate(request, TextPage, {"html": self._html})
                if not is_page or len(self.get_sessions("/")) + len(self._beginning) < MOST_PAGES:
                    if is_page:
                        self._beginning.add(request)
                    return super().find_handler(request, **settings)
                answer = {"status": 503, "words": _CROWDED}
        return self.get_handler_delegate(request, Answer, answer)

    def log_request(self, handler: RequestHandler) -> None:
        """Note that a request is answered; Tornado calls this at the end of each."""
        self._beginning.discard(handler.request)
        super().log_request(handler)


def serve(
    shown: Shown,
    listener: socket.socket,
    greet: Callable[[str], object],
    browser: bool,
) -> int:
    """Serve pages until Ctrl-C or SIGTERM; return the exit status."""
    for name in ("bokeh", "tornado"):  # a page shows its own errors
        logging.getLogger(name).setLevel(logging.CRITICAL)
    status, loop, host = 0, IOLoop.current(), "{}:{}".format(*listener.getsockname())

    def end(number: int, frame: object) -> None:
        nonlocal status
        status = INTERRUPTED if number == signal.SIGINT else TERMINATED
        loop.add_callback_from_signal(loop.stop)

    def fill(document: Document) -> None:
        if not status and not isinstance(shown, str):  # otherwise the server ends
            shown(document)

    owners = OwnersServer(shown if isinstance(shown, str) else fill, host)
    http = HTTPServer(owners)
    http.add_socket(listener)
    server = BaseServer(loop, owners, http)
    address = f"http://{host}{ENTRY}?token={owners.token}"
    greet(address)
    before = {number: signal.signal(number, end) for number in (signal.SIGINT, signal.SIGTERM)}
    try:
        server.start()
        if browser:  # in a thread, as one that runs in a terminal would block
            show = threading.Thread(target=webbrowser.open, args=(address,), daemon=True)
            loop.call_later(0.1, show.start)
        loop.start()
    finally:
        server.stop(wait=False)
        for number, handler in before.items():
            signal.signal(number, handler)
    return status
