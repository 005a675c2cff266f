"""Fill the cache of compiled kernels before runs need them: for clusters, and for images.

As a command: `nlds-vines compile [KIND ...]`.
"""

from __future__ import annotations

import argparse
import os
import time
from collections.abc import Iterator, Sequence
from contextlib import ExitStack

from nlds_vines.bifurcation.request_file import load_scan
from nlds_vines.cli.command_main import DONE, Command, say
from nlds_vines.cli.option_values import comma_separated
from nlds_vines.cli.parser import Parser
from nlds_vines.errors import RequestError, choice
from nlds_vines.model.contact_laws import HERTZ, LAWS
from nlds_vines.model.scenes import SCENES, scene_of
from nlds_vines.model.system import check_law
from nlds_vines.orbits import compilation
from nlds_vines.orbits.compilation import Needed
from nlds_vines.orbits.records import (
    SPECTRAL,
    WANTS,
    checked_want,
    possible_want,
    refuse_impossible,
    spectral,
)
from nlds_vines.orbits.solver_settings import METHODS
from nlds_vines.runs.threads import check_environment

_EXAMPLES = """\
examples:
  nlds-vines compile ssul
      what the default scan needs, into Numba's cache (the folder NUMBA_CACHE_DIR, if that is set)
  nlds-vines compile ssul ssbl --record regime,energy
      what scans of these dampers with these records need
  nlds-vines compile ssul --branches
      what `nlds-vines continuation` needs for this damper
exit status: 0 done, or all was there already; 2 the request is wrong, or a kernel could not be
compiled; 130 interrupted
"""


def needed_for(
    kinds: Sequence[str], record: Sequence[str] | None, method: str, law: str = HERTZ.name
) -> list[Needed]:
    """Return what kernels are needed for: the `kinds`, none for all, a `record`, and a `law`.

    By default the record is that of the default scan.  Raises `RequestError` for a kind, a record,
    a method or a law that there is not, or not together.
    """
    choice("--law", law, LAWS)
    choice("--method", method, METHODS)
    asked = [choice("KIND", kind, SCENES) for kind in dict.fromkeys(kinds or SCENES)]
    for kind in kinds:
        check_law(kind, law, "")
    chosen = [SCENES[kind].under(law) for kind in asked if SCENES[kind].walls or law == HERTZ.name]
    want = load_scan(None).want if record is None else checked_want(record)
    if kinds and record is not None:
        for scene in chosen:
            refuse_impossible(want, scene, method)
    # spectra rest on a run of its own, of which nothing but the section is noted
    runs = [tuple(word for word in want if word not in SPECTRAL)]
    runs += [("section",)] if spectral(want) else []
    found = ((scene.key, possible_want(run, scene, method)) for scene in chosen for run in runs)
    return [Needed(key, method, possible) for key, possible in found if possible]


def compile_kernels(needed: Needed) -> Iterator[str]:
    """Compile the kernels that are needed, unless the cache has them; yield a line for each.

    They are compiled in processes of their own, the verdict beside the others where it can be.
    Raises `RequestError` where a kernel cannot be compiled.
    """
    compilation.refuse_without_memory()
    kernels = compilation.kernels_of(needed.want)
    others = [name for name in kernels if name != "verdict"]
    with ExitStack() as stack:
        at_work = [_begun(stack, others, needed)]
        if "verdict" in kernels:
            if not compilation.may_help():
                yield from _lines(needed.scene, at_work.pop())
            at_work.append(_begun(stack, ["verdict"], needed))
        for process in at_work:
            yield from _lines(needed.scene, process)


def compile_branches(key: str) -> str:
    """Compile the kernels that follow branches of a scene, unless the cache has them.

    Returns a line that says so.
    """
    compilation.refuse_without_memory()
    from nlds_vines.continuation.section_map import BRANCHES, KERNELS, compile_for
    from nlds_vines.kernels.numerics.compiling import told_of_compilations

    compiled: list[object] = []
    began = time.perf_counter()
    with told_of_compilations(compiled.append):
        compile_for(scene_of(key))
    return _line(key, BRANCHES, time.perf_counter() - began if {*KERNELS} & {*compiled} else None)


def _line(key: str, kernel: str, seconds: float | None) -> str:
    """Return a line on a kernel that took so many seconds to compile, None where it was there."""
    return f"{key} {kernel}: " + ("already there" if seconds is None else f"{seconds:.1f} s")


def _begun(stack: ExitStack, kernels: Sequence[str], needed: Needed) -> compilation.Process:
    """Return a process that compiles kernels, and ends with the `stack`."""
    process = compilation.begin(kernels, needed)
    if process is None:
        raise RequestError("no process can be started to compile in")
    stack.callback(compilation.end, process)
    return process


def _lines(kind: str, process: compilation.Process) -> Iterator[str]:
    """Yield what a process says, in words, as soon as it does."""
    assert process.stdout is not None
    for line in process.stdout:
        kernel, word, *reason = line.split(maxsplit=2)
        if word == "failed":
            raise RequestError(f"{kind} {kernel}: {''.join(reason).strip()}")
        yield _line(kind, kernel, None if word == "known" else float(word))
    if status := process.wait():
        raise RequestError(f"{kind}: the process that compiles has ended with status {status}")


def _carry_out(options: argparse.Namespace) -> int:
    """Compile what the options name; return the exit status."""
    check_environment()
    records: list[list[str] | None] = [comma_separated(options.record)]
    if options.branches:
        if options.method != "exact":
            raise RequestError("--branches: branches are followed by method exact alone")
        records = [*(record for record in records if record), None]  # as of a scan
    asked = [
        needed
        for record in records
        for needed in needed_for(options.kind, record, options.method, options.law)
    ]
    if os.environ.get("NUMBA_DISABLE_JIT", "0") not in ("", "0"):
        raise RequestError("NUMBA_DISABLE_JIT is set in the environment: nothing is compiled")
    for needed in asked:
        for line in compile_kernels(needed):
            say(line)
    for key in dict.fromkeys(needed.scene for needed in asked) if options.branches else ():
        say(compile_branches(key))
    return DONE


def _declare(parser: Parser) -> None:
    known = ", ".join(SCENES)
    parser.add_argument("kind", nargs="*", metavar="KIND", help=f"of {known}; by default all")
    parser.add_argument(
        "--record", metavar="A,B,C", help=f"of {', '.join(WANTS)}; by default as the default scan"
    )
    parser.add_argument(
        "--law",
        metavar="LAW",
        default=HERTZ.name,
        help=f"of all contacts: {', '.join(LAWS)} ({HERTZ.name})",
    )
    parser.add_argument(
        "--branches", action="store_true", help="what continuation needs, in place of a scan"
    )
    parser.add_argument(
        "--method", metavar="METHOD", default="exact", help=f"{' or '.join(METHODS)} (exact)"
    )


COMMAND = Command(
    name="compile",
    description="Compile the kernels of scans before they are run.",
    examples=_EXAMPLES,
    declare=_declare,
    carry_out=_carry_out,
)
main = COMMAND.main
