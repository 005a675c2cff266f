"""A certificate for one run: with it, processes on this machine know one another and nobody else.

Whoever connects without it is refused: other users of the machine can neither send tasks nor read
results.  It stays in memory.
"""

from __future__ import annotations

import subprocess

_DAYS = 365  # for which it holds: longer than a run lasts
_COMMAND = (
    *("openssl", "req", "-x509", "-newkey", "rsa:2048", "-nodes", "-batch"),
    *("-subj", "/CN=nlds-vines", "-days", str(_DAYS)),
    *("-keyout", "/dev/stdout", "-out", "/dev/stdout"),
)
_KEY_ENDS = "PRIVATE KEY-----\n"
_PATIENCE = 60.0  # s


def new_certificate() -> tuple[str, str] | None:
    """Return a new key and its self-signed certificate, as PEM; None where that is not possible.

    The program `openssl` makes them, where the package `cryptography` is not installed.
    """
    try:
        done = subprocess.run(
            _COMMAND, capture_output=True, text=True, check=True, timeout=_PATIENCE
        )
    except (OSError, subprocess.SubprocessError):
        return None
    key, ends, certificate = done.stdout.rpartition(_KEY_ENDS)
    return (key + ends, certificate) if ends and "BEGIN CERTIFICATE" in certificate else None
