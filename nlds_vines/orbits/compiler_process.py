"""Compile the verdict of orbits, which stays on the disk: a program that `compilation` starts.

    python -m nlds_vines.orbits.compiler_process SCENE METHOD WANT,WANT,...

It ends when its standard input does.
"""

from __future__ import annotations

import os
import sys
import threading

from nlds_vines.model.scenes import scene_of
from nlds_vines.orbits.batch import Kernels, Wanted
from nlds_vines.orbits.solver_settings import Settings


def end_with_input() -> None:
    """End this process when its standard input ends, as it does when the parent is killed."""
    os.read(0, 1)  # unbuffered: the interpreter needs the lock of a buffer when it ends
    os._exit(1)


if __name__ == "__main__":
    threading.Thread(target=end_with_input, daemon=True).start()
    scene, method, want = sys.argv[1:]
    wanted = Wanted(scene_of(scene), want.split(","), method, "quick", Settings.of(method))
    Kernels(wanted, helped=False).compile("verdict")
    os._exit(0)  # without destructors, which take a second while the parent waits
