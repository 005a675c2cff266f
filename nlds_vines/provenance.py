"""Where an archive comes from: what was computed, from what, by what, and when."""

from __future__ import annotations

import platform
import sys
from collections.abc import Mapping
from datetime import UTC, datetime
from importlib import metadata
from typing import TYPE_CHECKING

from nlds_vines.scenes import SCENES

if TYPE_CHECKING:
    from nlds_vines.scan import Scan
    from nlds_vines.search.request import Tuning

Value = str | int | float

SCHEMA = 1
"""Number of the archive's layout; it rises when a reader of the old one would misread the new."""

LIBRARIES = ("numba", "llvmlite", "numpy", "scipy", "h5py")
"""The packages whose versions may change a bit of a result or of a file."""


def attributes(scan: Scan | Tuning, more: Mapping[str, Value]) -> dict[str, Value]:
    """Return the attributes of the archive of a scan, or of a tuning.

    Every parameter stands under its own name in SI units, `K` [N/m^1.5] wherever there is a
    contact; every assumption as `assumption_<parameter>`.  `more` is what only the run knows
    (threads, run time); its `command` is what the history tells, by default this process's.
    """
    system = scan.system
    now = datetime.now(UTC).isoformat(timespec="seconds")
    return {
        "Conventions": "CF-1.10",
        "title": scan.title,
        "source": f"nlds_vines {version('nlds-vines')}",
        "history": f"{now} {more.get('command', ' '.join(sys.argv))}",
        "schema": SCHEMA,
        "scan": scan.to_toml(),
        "scan_hash": scan.hash,
        "system": system.name,
        "kind": system.kind,
        **{name: float(value) for name, value in system.parameters.items()},
        **({"K": float(system.K)} if SCENES[system.kind].walls else {}),
        **{f"assumption_{name}": text for name, text in system.assumptions.items()},
        "python_version": platform.python_version(),
        **{f"{library}_version": version(library) for library in LIBRARIES},
        **more,
    }


def version(package: str) -> str:
    """Return the version of an installed package without importing it; `unknown` if it is not."""
    try:
        return metadata.version(package)
    except metadata.PackageNotFoundError:
        return "unknown"
