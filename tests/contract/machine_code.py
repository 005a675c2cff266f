"""What the compiled code of some orbits consists of, as JSON on standard output.

Run in a process of its own, in which entries are compiled afresh: those from a cache are machine
code alone. Inner kernels from a cache can be looked into. Not a test; `test_specialization.py` runs
it.
"""

import inspect
import json
import re
import sys

import numba
import numpy as np

from nlds_vines import load_system
from nlds_vines.engine.batch import parts_of
from nlds_vines.kernels.cells import cells
from nlds_vines.kernels.events import exact
from nlds_vines.kernels.numerics.compiling import Inner, Kernel, all_called
from nlds_vines.kernels.orbit import orbit
from nlds_vines.kernels.scene.codes import RESPONSE_COLUMNS
from nlds_vines.kernels.scene.scene import CellBuffers, Span
from nlds_vines.kernels.watch.observe import IMPACT_COLUMNS, Impacts
from nlds_vines.model.system import System

CASES = {
    "none": ("none", "exact", "section"),
    "tmd": ("tmd", "exact", "section"),
    "ssul": ("ssul-set6", "exact", "section"),
    "ssul energy": ("ssul-set6", "exact", "energy"),
    "ssul rk4": ("ssul-set6", "rk4", "section"),
    "ssbl": ("ssbl", "exact", "response"),
    "ssvi-b": ("ssvi-b", "exact", "impacts"),
    "restitution": ("restitution", "exact", "section"),
    "linear": ("linear", "exact", "section"),
    "power": ("power", "exact", "section"),
}
LAWS = {
    "restitution": {"law": "restitution", "e": 0.7},
    "linear": {"law": "linear", "kc": 1e6},
    "power": {"law": "power", "K": 1e7, "exponent": 1.2},
}
LOOPS = (orbit.orbit, orbit.linear_orbit)  # they run once a period or more often
KERNEL = re.compile(r"_ZN10nlds_vines7kernels(\w+)")


def kernel_of(symbol):
    """Return `module.function` of a mangled name of the kernels (lengths before the words)."""
    rest, words = KERNEL.match(symbol).group(1), []
    while length := re.match(r"\d+", rest):
        end = len(length.group()) + int(length.group())
        words.append(rest[len(length.group()) : end])
        rest = rest[end:]
    return ".".join(words[-2:])


def undecided(kinds):
    inside = [kind for one in kinds for kind in getattr(one, "types", ())]
    return any(isinstance(kind, numba.types.Optional) for kind in (*kinds, *inside))


def called(text):
    names = re.findall(r"call [^\n]*@(?:llvm\.)?(pow|sqrt|sin|cos|exp|log)\b", text)
    return sorted(set(names))


def contracts(text):
    """Return the operations of an LLVM module that carry a flag of fast mathematics."""
    flags = "fast|nnan|ninf|nsz|arcp|contract|afn|reassoc"
    return sorted(set(re.findall(rf"= (f\w+ (?:{flags})\b)", text)))


def compiled(name, method, want):
    """Run three periods of a system and return the code that this compiled."""
    if name in LAWS:
        system = load_system("ssul-set6", **LAWS[name])
    elif name == "ssvi-b":
        system = System(name, load_system("ssbl").parameters)
    else:
        system = load_system(name)
    run_cell = cells.run_cell.entry  # what Python calls
    watched = (run_cell, exact.touch_in, *LOOPS)
    before = {f: set(f.overloads) for f in watched}
    section = np.empty((3, 4 if system.scene.damper else 2))
    impacts = Impacts(np.zeros((9, IMPACT_COLUMNS)), np.zeros(1, np.int64))
    buffers = CellBuffers(
        section=section if want == "section" else None,
        impacts=impacts if want == "impacts" else None,
        energy=np.zeros(2) if want == "energy" else None,
        response=np.zeros(RESPONSE_COLUMNS) if want == "response" else None,
        violation=np.zeros(3) if system.scene.limit else None,
    )
    parts = parts_of(method, system.scene)
    run_cell(parts, system.cell, np.zeros(orbit.STATE_SIZE), Span(3, 3, 1), buffers)
    fresh = {f: sorted(set(f.overloads) - before[f], key=str) for f in watched}
    (signature,) = fresh[run_cell]
    entry = run_cell.overloads[signature].library
    parts = [entry, *entry.linked]
    kinds = {one.need.symbol: one.need.kinds for one in entry.linked}
    symbols = {function.name for part in parts for function in part.get_defined_functions()}
    kernels = {symbol for symbol in symbols if KERNEL.match(symbol)}
    text = run_cell.inspect_llvm(signature)
    loop = [(f, s) for f in LOOPS for s in fresh[f]]
    inner = [f.overloads[s].library for f, s in loop]
    reached = [one for library in inner for one in (library, *all_called(library, {}))]
    walks = [exact.touch_in.inspect_llvm(s) for s in fresh[exact.touch_in]]
    # its calls of these two, one of which is inlined in the other
    calls = [re.findall(r"call [^\n]*(first_touch|touch_of)B", walk) for walk in walks]
    asking = {symbol for symbol in kernels if undecided(kinds.get(symbol, ()))}
    return {
        "kernels": sorted(set(map(kernel_of, kernels))),
        "undecided": sorted(set(map(kernel_of, asking))),
        "mathematics": called(text),
        "loop": called("\n".join(one.get_llvm_str() for one in reached)),
        "absent": [absent(f, s) for f, s in loop],
        "walks": [max(map(names.count, names), default=0) for names in calls],
        "contracts": contracts(text),
    }


def absent(function, types):
    """Return the names of the arguments and of their fields that are None in one compilation."""
    names = inspect.signature(function.py_func).parameters
    kinds = list(zip(names, types, strict=True))
    for _, kind in list(kinds):
        if hasattr(kind, "fields"):  # a named tuple
            kinds += zip(kind.fields, kind.types, strict=True)
    return [name for name, kind in kinds if str(kind) == "none"]


loaded = Kernel._loaded


def loaded_if_inner(kernel, kinds):
    return loaded(kernel, kinds) if isinstance(kernel, Inner) else None


if __name__ == "__main__":
    Kernel._loaded = loaded_if_inner
    cases = {name: compiled(*case) for name, case in CASES.items()}
    # for comparison, a function that is not compiled strictly
    function = numba.njit(lambda x: x * x + x, fastmath=True)
    function(1.5)
    loose = {"contracts": contracts(*function.inspect_llvm().values())}
    json.dump({**cases, "loose": loose}, sys.stdout)
