"""The manifest of a folder of parts: whose scan this is, and what it takes to finish it."""

from __future__ import annotations

import json
import sys
from dataclasses import asdict, dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING

from nlds_vines import durable
from nlds_vines._toml import parse_toml
from nlds_vines.errors import RequestError
from nlds_vines.provenance import now
from nlds_vines.scan import load_scan

if TYPE_CHECKING:
    from nlds_vines.scan import Scan

NAME = "manifest.json"
"""The manifest's name in the folder of parts."""


@dataclass(frozen=True)
class Manifest:
    """Whose parts these are.

    Arguments: `toml` and `scan_hash` are the scan's; `argv` and `began` (UTC) tell of the run that
    began it; `overwrite` says that it was told to replace an archive.
    """

    title: str
    scan_hash: str
    toml: str
    argv: list[str]
    began: str
    overwrite: bool = False

    @classmethod
    def of(cls, scan: Scan, scan_hash: str, overwrite: bool = False) -> Manifest:
        """Return the manifest of a scan that this process begins."""
        return cls(scan.title, scan_hash, scan.to_toml(), sys.argv, now(), overwrite)

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

    @cached_property
    def scan(self) -> Scan:
        """The scan itself."""
        return load_scan(parse_toml(self.toml, NAME))
