"""How far off the time is that `--dry-run` estimates: scans of several scenes, laws and records.

    python -m benchmarks.estimates

Each scan is estimated and then computed; the ratio of both times is printed.  Exit status 1 where
one is further off than `FACTOR`.
"""

from __future__ import annotations

import sys
import tempfile
from pathlib import Path
from typing import Any

from nlds_vines.bifurcation.estimate import estimate
from nlds_vines.bifurcation.request_file import load_scan
from nlds_vines.bifurcation.run import run
from nlds_vines.cli.run_options import RunOptions

FACTOR = 1.5
"""The most by which an estimate may be off, up or down."""

USUAL: dict[str, Any] = {"vary": {"omega": {"start": 5.0, "stop": 8.0, "num": 3001}}}
MAP: dict[str, Any] = {
    "vary": {
        "omega": {"start": 7.0, "stop": 8.0, "num": 61},
        "P": {"start": 400.0, "stop": 1200.0, "num": 41},
    }
}
ENERGY = {"record": {"want": ["energy"]}}
REGIMES = {"record": {"want": ["regime", "settling"]}}

SCANS: dict[str, dict[str, Any]] = {
    "the default diagram, more cells": USUAL,
    "energies alone": {**USUAL, **ENERGY},
    "SSbl NES": {**USUAL, "system": "ssbl"},
    "TMD, energies of a map": {**MAP, **ENERGY, "system": "tmd"},
    "regimes of a map, two random starts": {
        **MAP, **REGIMES, "start": {"policy": "random", "count": 2},
    },
    "sweeps up and down": {**USUAL, "start": {"policy": "both"}},
    "restitution": {
        **USUAL, "set": {"law": "restitution", "e": 0.7},
    },
    "errors": {
        "vary": {"omega": {"start": 5.0, "stop": 8.0, "num": 601}},
        "record": {"want": ["regime", "error"]},
    },
}  # fmt: skip
"""The scans, by name, in tables laid over the default one."""


def measured(name: str, folder: Path) -> tuple[float, float]:
    """Return the seconds that are estimated, and those that the scan takes."""
    scan = load_scan({"system": "ssul-set6", **SCANS[name]})
    took = run(scan, folder / "scan.h5", RunOptions(overwrite=True)).seconds  # and compiles
    guess = estimate(scan).seconds
    assert guess is not None
    return guess, took


def main() -> int:
    """Measure all of them; return the exit status."""
    far = 0
    with tempfile.TemporaryDirectory() as folder:
        for name in SCANS:
            guess, took = measured(name, Path(folder))
            far += not 1.0 / FACTOR <= guess / took <= FACTOR
            line = f"{name:<38} estimated {guess:7.2f} s, took {took:7.2f} s: {guess / took:5.2f}"
            print(line, flush=True)
    return int(far > 0)


if __name__ == "__main__":
    sys.exit(main())
