"""What the tests of the default tier may compile: four configurations, each shared by many tests.

Run as a program it compiles them, unless they are there, and prints the names of their files.
"""

import json
import sys

import numpy as np

import nlds_vines as nv
from nlds_vines.kernels.numerics.compiling import Kernel
from nlds_vines.model.scenes import scene_of

USUAL = ("section", "impacts", "energy", "regime")

SCANS = (("ssul", USUAL), ("tmd", ("section",)), ("oscillator", ("section", "impacts")))
"""Scenes and records of scans; beside them an orbit and branches of `ssul`."""


def compile_all():
    """Compile the four configurations."""
    from nlds_vines.engine.batch import Kernels, Wanted
    from nlds_vines.engine.section_map import SectionMap
    from nlds_vines.engine.solver_settings import Settings
    from nlds_vines.kernels.numerics.elementary import exp, fill_cos_sin, fill_exp, log
    from nlds_vines.kernels.numerics.tones import fill_tones
    from nlds_vines.kernels.orbit.repetition import TOLERANCE, period_of

    for scene, want in SCANS:
        wanted = Wanted(scene_of(scene), want, "exact", "quick", Settings.of("exact"))
        Kernels(wanted).prepare()
    nv.simulate(nv.load_system("ssul-set6"), periods=1, quiet=True)
    SectionMap(nv.load_system("ssul-set6"), ("omega",)).compile(None)
    fill_cos_sin(np.zeros(1), np.zeros(1), np.zeros(1))  # by which loads have their coefficients
    fill_exp(np.zeros(1), np.zeros(1))
    fill_tones(np.zeros(1), np.zeros(1), np.zeros(1), np.zeros(1), np.zeros((1, 15)))
    log(1.0)
    exp(0.0)  # by which branches compare their multipliers with the damping
    period_of(np.zeros((4, 4)), TOLERANCE)  # by which portraits find theirs


def files():
    """Return the files of all kernels that Python calls and that this process has used."""
    modules = [module for name, module in sys.modules.items() if name.startswith("nlds_vines.")]
    values = [value for module in modules for value in vars(module).values()]
    kernels = {value for value in values if isinstance(value, Kernel)}
    kernels |= {vars(kernel)["entry"] for kernel in kernels if "entry" in vars(kernel)}
    return [kernel.file(kinds) for kernel in kernels for kinds in kernel.overloads]


if __name__ == "__main__":
    compile_all()
    print(json.dumps(files()))
