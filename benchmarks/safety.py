"""What safety costs: run times with parts, seals and checks, and without them.

    python -m benchmarks.safety [RUNS] [SCAN.toml]

The default scan (Figure 8) or another is computed again and again in turn: as it is, and with the
archive written straight from memory, without parts, seals, forced writes and comparison.
"""

import os
import sys
import tempfile
import time
from contextlib import ExitStack
from pathlib import Path
from statistics import median
from unittest.mock import patch

from nlds_vines.archives import durable
from nlds_vines.archives.provenance import makers
from nlds_vines.bifurcation import run as scan_run
from nlds_vines.bifurcation.block_files import PartFiles, Parts
from nlds_vines.bifurcation.request_file import load_scan
from nlds_vines.cli.run_options import RunOptions
from nlds_vines.runs.partfile import Made, Part


def keep(self, block, arrays, seconds=0.0, threads=1):
    """Stand in for `Parts.write`: keep the results in memory."""
    content = {name: self.files._as_stored(name, array) for name, array in arrays.items()}
    self._fresh[block.index] = Part(content, Made(makers(), seconds, threads))


def unsafe():
    """Return what switches off all that is there for safety alone."""
    stack = ExitStack()
    stack.enter_context(patch.object(Parts, "write", keep))
    stack.enter_context(patch.object(Parts, "sound", lambda *_: iter(())))
    stack.enter_context(patch.object(PartFiles, "there", lambda self, blocks: list(blocks)))
    stack.enter_context(patch.object(durable, "reserve", lambda *_: None))
    stack.enter_context(patch.object(durable, "replace", os.replace))
    return stack


def measured(scan, path):
    """Return wall and CPU time [s] of one run."""
    wall, cpu = time.perf_counter(), time.process_time()
    scan_run.run(scan, path, RunOptions(overwrite=True))
    return time.perf_counter() - wall, time.process_time() - cpu


def main(runs=9, source=None):
    """Measure and print."""
    scan = load_scan(source)
    times: dict[str, list[tuple[float, float]]] = {"safe": [], "unsafe": []}
    with tempfile.TemporaryDirectory(dir=".") as folder:
        path = Path(folder) / "a.h5"
        scan_run.run(scan, path)  # compiles
        for _ in range(runs):
            times["safe"].append(measured(scan, path))
            with unsafe():
                times["unsafe"].append(measured(scan, path))
    for index, kind in enumerate(("wall", "CPU")):
        safe, plain = (median(found[index] for found in times[name]) for name in times)
        ratios = [a[index] / b[index] - 1 for a, b in zip(*times.values(), strict=True)]
        print(
            f"{kind}: {safe:.3f} s safe, {plain:.3f} s unsafe; "
            f"safety costs {100 * median(ratios):.1f} % (median of {runs} pairs)"
        )


if __name__ == "__main__":
    main(*(int(text) for text in sys.argv[1:2]), *sys.argv[2:3])
