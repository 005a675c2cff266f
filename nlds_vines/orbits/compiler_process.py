"""Compile kernels of orbits before they are needed: they are left on the disk.

    python -m nlds_vines.orbits.compiler_process KERNEL,KERNEL,... SCENE METHOD WANT,WANT,...

A program for `compilation`.  It prints a line for each kernel: its name, then the seconds that
compiling took, or `known` where it was there, or `failed` and why.  It ends when its standard input
does.
"""

from __future__ import annotations

import os
import sys
import threading
import time
from collections.abc import Sequence

from nlds_vines.kernels.cells import lanes
from nlds_vines.kernels.numerics.compiling import told_of_compilations
from nlds_vines.model.scenes import scene_of
from nlds_vines.orbits.batch import Kernels, Wanted
from nlds_vines.orbits.compilation import Needed
from nlds_vines.orbits.solver_settings import Settings

KNOWN, FAILED = "known", "failed"
"""The words in place of the seconds."""


def compile_kernel(kernel: str, needed: Needed) -> float | None:
    """Compile a kernel; return the seconds it took, None where it was there."""
    scene, method, want = needed
    wanted = Wanted(scene_of(scene), want, method, "quick", Settings.of(method))
    compiled: list[object] = []
    began = time.perf_counter()
    with told_of_compilations(compiled.append):
        Kernels(wanted, helped=False).compile(kernel)
    took = time.perf_counter() - began
    return took if {lanes.run_lanes, lanes.judge_lanes} & set(compiled) else None


def main(arguments: Sequence[str]) -> int:
    """Compile what the arguments name; return the exit status."""
    threading.Thread(target=_end_with_input, daemon=True).start()
    kernels, scene, method, want = arguments
    for kernel in kernels.split(","):
        try:
            took = compile_kernel(kernel, Needed(scene, method, tuple(want.split(","))))
        except (Exception, SystemExit) as error:
            text = " ".join(str(error).split()) or type(error).__name__
            print(kernel, FAILED, text, flush=True)
            return 1
        print(kernel, KNOWN if took is None else took, flush=True)
    return 0


def _end_with_input() -> None:
    """End this process with its standard input: who has begun it is not there any more."""
    os.read(0, 1)  # no buffer, whose lock the interpreter would want when it ends
    os._exit(1)


if __name__ == "__main__":
    status = main(sys.argv[1:])
    sys.stdout.flush()
    os._exit(status)  # another process waits: nothing is put away, which takes a second
