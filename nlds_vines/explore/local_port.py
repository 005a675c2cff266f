"""The port of a page, on this machine alone."""

from __future__ import annotations

import socket

from nlds_vines.errors import RequestError

ADDRESS = "127.0.0.1"
"""The only address that is listened on."""

PORT = 5006
"""The port unless another is asked for; 0 takes one that is free."""


def listening(port: int) -> socket.socket:
    """Return a socket that listens on a port of this machine alone.

    Raises `RequestError` where the port is taken.
    """
    found = socket.socket(socket.AF_INET, socket.SOCK_STREAM)
    try:
        found.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        found.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)  # connections inherit it
        found.bind((ADDRESS, port))
        found.listen(64)
    except OSError as error:
        found.close()
        raise RequestError(
            f"--port {port} of {ADDRESS} cannot be used: {error.strerror}; "
            "--port 0 takes one that is free"
        ) from None
    found.setblocking(False)
    return found
