"""The default diagram explained by its branches, and what branches cost: docs/borders.md, measured.

python -m benchmarks.branches                 print the page
python -m benchmarks.branches -o FILE.md      write it, and its picture beside it
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from tempfile import TemporaryDirectory

from benchmarks.shooting import lines
from nlds_vines.__main__ import main as command
from nlds_vines.archives.archive import read
from nlds_vines.archives.durable import write_text
from nlds_vines.cli.markdown_tables import table
from nlds_vines.continuation.command import follow
from nlds_vines.continuation.picture import picture as over
from nlds_vines.continuation.regime_borders import borders_of, report, strays
from nlds_vines.continuation.result import Continued, continued
from nlds_vines.model.catalogue import load_system

SCANNED = "omega=5:8"
CROWDED = "omega=7.3:7.8"  # where the borders are: the part that is drawn
UNSTABLE = "60"
PLANE = ("6.8:8", "400:1200")  # omega [rad/s] and P [N]
AROUND = (5.0, 9.0)
BISTABLE = load_system("ssul-set6", omega=7.45)


def explained(folder: Path) -> tuple[Continued, Path]:
    """Return the branches of every orbit that the default scan finds, and the scan's archive."""
    scan, branches = folder / "figure8.h5", folder / "branches.h5"
    command(["bifurcation", "-o", str(scan), "--quiet"])
    arguments = ["--from", str(scan), "--along", SCANNED, "--unstable", UNSTABLE, "--quiet"]
    command(["continuation", *arguments, "-o", str(branches)])
    return continued(branches), scan


def draw(scan: Path, folder: Path, picture: Path) -> None:
    """Draw the branches over the crowded part of the scan."""
    path = folder / "crowded.h5"
    arguments = ["--from", str(scan), "--along", CROWDED, "--unstable", UNSTABLE, "--quiet"]
    command(["continuation", *arguments, "-o", str(path)])
    over(scan).save(path, picture)


def draw_plane(folder: Path, picture: Path) -> None:
    """Draw the curves of T and 2T in a plane over the map of its regimes."""
    scan, path = folder / "map.h5", folder / "plane.h5"
    sampling = ["--transient", "300", "--periods", "60", "--record", "regime", "--quiet"]
    axes = ["--vary", f"omega={PLANE[0]}:97", "--vary", f"P={PLANE[1]}:65"]
    command(["bifurcation", *axes, *sampling, "-o", str(scan)])
    arguments = ["--along", f"omega={PLANE[0]}", "--plane", f"P={PLANE[1]}", "--doublings", "1"]
    command(["continuation", *arguments, "--set", "omega=6.9", "--quiet", "-o", str(path)])
    over(scan).save(path, picture)


def spent(work: Callable[[], Continued]) -> tuple[float, Continued]:
    """Return the CPU time [s] of a piece of work, once everything is compiled, and its result."""
    work()
    began = time.process_time()
    found = work()
    return time.process_time() - began, found


def costs() -> Iterator[str]:
    """Yield the table of what branches cost."""
    jobs = {
        "T,1 of Set 6, 5 to 9 rad/s": lambda: follow("ssul-set6", "omega", AROUND),
        "the same, to 2T": lambda: follow("ssul-set6", "omega", AROUND, doublings=1),
        "the same, to 8T": lambda: follow("ssul-set6", "omega", AROUND, doublings=3),
        "3T,2 of Set 6, an isola": lambda: follow(BISTABLE, "omega", AROUND, "3T,2"),
        "curves of PD and GR, P = 400 to 1200 N": lambda: follow(
            "ssul-set6", "omega", AROUND, plane=("P", 400.0, 1200.0)
        ),
    }
    rows = []
    for name, work in jobs.items():
        seconds, found = spent(work)
        points = len(found.tables["periodicity"]) + len(found.tables.get("curve_of_point", ()))
        special = len(found.special)
        rows.append([name, f"{points}", f"{special}", f"{seconds:.2f} s"])
    head = ["job", "points", "special points", "CPU time"]
    yield from table(head, rows, right=(1, 2, 3))


def page(found: Continued, scan: Path, picture: str) -> Iterator[str]:
    """Yield the page, line by line."""
    yield "# The default diagram explained"
    yield ""
    yield (
        "Written by `python -m benchmarks.branches -o docs/borders.md`. The default scan "
        "(Figure 8) has 1201 frequencies. From the last cell of each regime, its orbit is followed "
        "along its branch to the next cell, and back from there. A special point ends it, or it "
        "lives on and is stable: then the start from rest has left its basin."
    )
    yield ""
    with read(scan) as view:
        periodic = int((view["periodicity"] > 0).sum())
        missing = strays(found, view)
        yield (
            f"{len(found.branches)} branches with {len(found.special)} special points. Of "
            f"{periodic} periodic orbits of the scan, {len(missing)} lie on none of them."
        )
        yield ""
        yield f"![Branches over the default diagram]({picture})"
        yield ""
        yield "Ticks at the foot are borders: grey where the start has only changed basins."
        yield ""
        borders = borders_of(found, view)
        yield from report(found, view, borders)
    yield ""
    yield "## Each of these points again"
    yield ""
    yield (
        "By shooting: the equation of motion written anew, SciPy's DOP853 from touch to touch "
        "(`benchmarks/shooting.py`). The last column is relative."
    )
    yield ""
    yield from lines(found, borders)
    yield ""
    yield "## What branches cost"
    yield ""
    yield "CPU time of one thread, once compiled:"
    yield ""
    yield from costs()


def main() -> None:
    """Print the page, or write it and its picture."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("-o", "--output", type=Path, metavar="FILE.md")
    options = parser.parse_args()
    with TemporaryDirectory() as name:
        folder = Path(name)
        found, scan = explained(folder)
        picture = "borders.png"
        lines = list(page(found, scan, picture))
        if options.output is None:
            print(*lines, sep="\n")
            return
        draw(scan, folder, options.output.parent / picture)
        draw_plane(folder, options.output.parent / "plane.png")
        write_text(options.output, "\n".join(lines) + "\n")


if __name__ == "__main__":
    main()
