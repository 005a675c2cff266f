"""Small scans of all kinds and one orbit of each; prints a digest of every array, as JSON.

Run in a process of its own, whose environment chooses the processor and the libraries. Not a test;
`test_same_bits.py` runs it. The arguments are the names of the cases; with `--code` as the first,
it looks into everything that is compiled on the way (nothing is, where a cache has it).
"""

import hashlib
import json
import re
import sys
import tempfile
from pathlib import Path

import llvmlite.binding as llvm
import numpy as np
from numba.core.codegen import CPUCodeLibrary

import nlds_vines as nv
from nlds_vines import load_system

ALL = ["section", "impacts", "energy", "peak", "regime", "lyapunov", "settling", "evidence"]
NO_WALL = [name for name in ALL if name != "impacts"]
SAMPLING = {"transient": 200, "periods": 60}
RK4 = {"method": "rk4", "period_steps": 128}
RANDOM = {"policy": "random", "count": 2, "seed": 3}

SSUL = {
    "system": "ssul-set6",
    "vary": {"omega": {"start": 7.3, "stop": 7.6, "num": 7}},
    "set": {"K": 2.5e7},
    "start": {"policy": "both"},
}

# Each with periodic and chaotic orbits, as far as the scene has them.
CASES = {
    "two walls": {
        "system": "ssbl",
        "vary": {"omega": {"values": [5.2, 6.28, 6.9, 7.6]}, "K": {"values": [1e7, 2.5e7]}},
        "start": RANDOM,
        "record": {"want": [*ALL, "clearance"]},
    },
    # the scene and records of most tests
    "usual": {**SSUL, "record": {"want": ["section", "impacts", "energy", "regime"]}},
    "one wall": {**SSUL, "record": {"want": [*ALL, "clearance"]}},
    "fixed steps": {
        **SSUL,
        "vary": {"omega": {"values": [6.28, 7.4, 7.575]}},
        "start": RANDOM,
        "sampling": {"transient": 100, "periods": 30, "effort": "quick", **RK4},
        "record": {"want": ALL},
    },
    "no damper": {
        "system": "none",
        "vary": {"omega": {"values": [5.0, 6.28, 9.0]}, "c1": {"values": [0.0, 20.0]}},
        "start": RANDOM,
        "record": {"want": NO_WALL},
    },
    "no wall": {
        "system": "tmd",
        "vary": {"omega": {"values": [5.0, 6.28, 9.0]}},
        "start": RANDOM,
        "record": {"want": NO_WALL},
    },
    "a limit": {
        "system": {"kind": "ssvi-b", "parameters": dict(load_system("ssbl").parameters)},
        "vary": {"omega": {"values": [5.6, 6.28]}},
        "record": {"want": ["section", "impacts", "energy"]},
    },
}

RECORDED = ("section", "impacts", "energy", "peak", "clearance", "trajectory")

# Exact, whoever computes them; memory and errors of Python; Numba's own.
HARMLESS = re.compile(
    r"llvm\.|NRT_|Py|_Py|numba_|_ZN|_Z\w*numba|\.numba|get_|set_|mem(cpy|set|move)|"
    r"(floor|ceil|trunc|rint|sqrt|fabs|copysign|abort|fprintf|printf|malloc|free|do_scheduling\w*)$"
)
FUSED = re.compile(r"\bv?fn?m(?:add|sub|la|ls)\w*")
FLAGS = re.compile(r"= f\w+ (?:fast|nnan|ninf|nsz|arcp|contract|afn|reassoc)\b")


def digest(values):
    values = np.asarray(values)
    data = json.dumps(values.tolist()) if values.dtype == object else values.tobytes()
    data = data.encode() if isinstance(data, str) else data
    return hashlib.sha256(f"{values.dtype} {values.shape}".encode() + data).hexdigest()[:16]


def scanned(case, threads):
    """Return the digests of what the archive of a case holds, and its labels."""
    with tempfile.TemporaryDirectory() as folder:
        document = {"sampling": SAMPLING, **CASES[case]}
        path = nv.scan(nv.load_scan(document), to=Path(folder) / "a.h5", threads=threads)
        with nv.read(path) as archive:
            names = [*archive.names, *archive.dims("status")]
            digests = {f"{case}: {name}": digest(archive[name]) for name in names}
            if "label" in archive.names:
                digests[f"{case}: labels"] = sorted(set(archive["label"].ravel().tolist()))
    return digests


def followed(name, changes, **options):
    system = load_system(name, **changes)
    record = RECORDED if system.scene.walls else ("section",)
    orbit = nv.simulate(system, 40, record=record, **options)
    numbers = {"state": orbit.state, "energy": [orbit.E1max, orbit.E2max, orbit.E1peak]}
    numbers |= {"section": orbit.section, "trajectory": orbit.trajectory}
    if orbit.impacts is not None:
        names = orbit.impacts.dtype.names[1:]
        numbers["impacts"] = np.array([orbit.impacts[column] for column in names])
    numbers = {key: np.array(values) for key, values in numbers.items() if values is not None}
    return {f"{name} {options}: {key}": digest(values) for key, values in numbers.items()}


def listen():
    """Return a list that takes the LLVM text of everything that is compiled from now on."""
    texts, finalize = [], CPUCodeLibrary._finalize_final_module

    def noted(self):
        texts.append(str(self._final_module))
        finalize(self)

    CPUCodeLibrary._finalize_final_module = noted
    return texts


def fused_on_arm(text):
    """Return the fused operations in the ARM64 code of an LLVM module, and whether it has any code.

    The module has been optimized for this processor; what would be fused on another is decided
    last, by what the operations of the module allow.
    """
    llvm.initialize_all_targets()
    llvm.initialize_all_asmprinters()
    triple = "aarch64-unknown-linux-gnu"
    machine = llvm.Target.from_triple(triple).create_target_machine(cpu="neoverse-v1", opt=3)
    text = re.sub(r"(?m)^target (datalayout|triple) = .*$", "", text)
    text = re.sub(r'"target-(cpu|features)"="[^"]*"', "", text)
    references = r"(?:tail )?call (\w+) @llvm\.x86\.[^\n]*"  # they are counted
    text = re.sub(references, r"add \1 0, 0", text)
    module = llvm.parse_assembly(text)
    module.triple = triple
    return sorted(set(FUSED.findall(machine.emit_assembly(module))))


def code(texts):
    """Return the external calls of LLVM modules and the operations that may round in two ways."""
    declared = re.compile(r'(?m)^declare [^@]*@"?([\w.$]+)')
    called = {name for text in texts for name in declared.findall(text)}
    # the loops over lanes, each with all that it calls
    kernels = [text for text in texts if re.search(r"(?m)^define [^\n]*_lanes", text)]
    return {
        "modules": len(texts),
        "called": sorted(name for name in called if not HARMLESS.match(name)),
        "intrinsics": sorted(name for name in called if name.startswith("llvm.")),
        "flags": sorted({flag for text in texts for flag in FLAGS.findall(text)}),
        "fused on ARM64": sorted({name for text in kernels for name in fused_on_arm(text)}),
        "loops": len(kernels),
    }


def main(arguments):
    """Print the digests of the cases, and of the orbits if `orbits` is among them."""
    looks = arguments[0] == "--code"
    texts, threads = (listen(), 1) if looks else ([], None)  # with one, nobody helps to compile
    digests = {}
    for case in arguments[looks:]:
        if case != "orbits":
            digests |= scanned(case, threads)
            continue
        for method in ("exact", "rk4"):
            digests |= followed("ssul-set6", {"omega": 7.45}, method=method)
            digests |= followed("ssbl", {}, method=method)
        digests |= followed("none", {})
    if looks:
        digests["code"] = code(texts)
    json.dump(digests, sys.stdout)


if __name__ == "__main__":
    main(sys.argv[1:])
