"""The manifest of a folder of parts: whose run this is, and what it takes to finish it."""

from __future__ import annotations

import json
import sys
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from nlds_vines.archives import durable
from nlds_vines.archives.provenance import Request, now
from nlds_vines.errors import RequestError

if TYPE_CHECKING:
    pass


NAME = "manifest.json"
"""The manifest's name in the folder of parts."""

SCAN, TUNING, SURVEY = "scan", "tuning", "survey"
"""What may be under way: a scan, in blocks; the search of a tuning, design by design; a survey of
measurements, task by task."""


@dataclass(frozen=True)
class Manifest:
    """Whose parts these are.

    Arguments: `toml` and `scan_hash` are the request's, `content` is its kind; `argv` and `began`
    (UTC) tell of the run that began it; `overwrite` says that it was told to replace an archive.
    """

    title: str
    scan_hash: str
    toml: str
    argv: list[str]
    began: str
    overwrite: bool = False
    content: str = SCAN

    @classmethod
    def of(cls, request: Request, content: str = SCAN, overwrite: bool = False) -> Manifest:
        """Return the manifest of a request that this process begins."""
        toml = request.to_toml()
        return cls(request.title, request.hash, toml, sys.argv, now(), overwrite, content)

    @classmethod
    def read(cls, folder: Path) -> Manifest | None:
        """Return the manifest in a folder; None if nothing was begun there.

        Raises `RequestError` if it is damaged.
        """
        path = folder / NAME
        try:
            return cls(**json.loads(durable.read(path)))
        except (FileNotFoundError, NotADirectoryError):
            return None
        except (ValueError, TypeError) as error:
            raise RequestError(f"{path} is damaged ({error}): use --overwrite") from error

    def write(self, folder: Path) -> None:
        """Put it into a folder (OSError)."""
        durable.write(folder / NAME, json.dumps(asdict(self)).encode())


def refuse_others(words: str, content: str) -> None:
    """Raise `RequestError`, beginning with `words`, where a content is not that of a scan."""
    if content != SCAN:
        raise RequestError(f"{words} a {content}, not a scan")
