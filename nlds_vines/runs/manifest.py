"""The manifest of a folder of parts: the request they belong to, and who began the run."""

from __future__ import annotations

import json
import sys
from dataclasses import asdict, dataclass
from pathlib import Path

from nlds_vines.archives import durable
from nlds_vines.archives.provenance import SCAN, Request, now
from nlds_vines.errors import RequestError

NAME = "manifest.json"
"""The manifest's name in the folder of parts."""


@dataclass(frozen=True)
class Manifest:
    """The request that parts belong to, and the run that began them.

    Arguments: `title`, `toml` and `scan_hash` are those of the request, `content` is its kind;
    `argv` are the arguments of the process that began the run, at the time `began` (UTC), and
    `overwrite` is True where it is to replace an archive.
    """

    title: str
    scan_hash: str
    toml: str
    argv: list[str]
    began: str
    overwrite: bool = False
    content: str = SCAN

    def __post_init__(self) -> None:
        """Raise TypeError for an entry of another type: a manifest is read from a file."""
        texts = (self.title, self.scan_hash, self.toml, self.began, self.content)
        if not (isinstance(self.argv, list) and isinstance(self.overwrite, bool)):
            raise TypeError("argv or overwrite is of another type")
        if not all(isinstance(text, str) for text in (*texts, *self.argv)):
            raise TypeError("a text is of another type")

    @classmethod
    def of(cls, request: Request, overwrite: bool = False) -> Manifest:
        """Return the manifest of a request that this process begins."""
        toml, kind = request.to_toml(), request.content
        return cls(request.title, request.hash, toml, sys.argv, now(), overwrite, kind)

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
        except (ValueError, TypeError, RecursionError) as error:
            raise RequestError(
                f"{path} is damaged ({error}): --resume of the same request keeps what was "
                "computed, --overwrite discards it"
            ) from error

    def write(self, folder: Path) -> None:
        """Put it into a folder (OSError)."""
        durable.write(folder / NAME, json.dumps(asdict(self)).encode())
