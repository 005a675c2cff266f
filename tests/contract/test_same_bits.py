"""The same scans give the same bits whatever the processor, the C library, BLAS and NumPy do.

Each setting is a process of its own, which runs the scans of `orbits_of_all_kinds.py` and prints a
digest of every array. Standard are two settings that hold everything at once, one of which compiles
for a processor of the oldest kind; behind `long` stand each of them alone, and all scenes.
"""

import json
import os
import platform
from textwrap import dedent

import numpy as np
import orbits_of_all_kinds
import pytest
from commands import printed

from nlds_vines.bifurcation.request import load_scan
from nlds_vines.bifurcation.run import Computer
from nlds_vines.scans.block import Block

pytestmark = pytest.mark.kernels

PROGRAM = orbits_of_all_kinds.__file__
CASES = ("two walls", "one wall", "fixed steps", "no damper", "no wall", "a limit", "orbits")
X86 = platform.machine().lower() in ("x86_64", "amd64")


def dispatched():
    """Return the processor features that NumPy uses beyond its baseline."""
    try:
        from numpy._core._multiarray_umath import __cpu_dispatch__, __cpu_features__
    except ImportError:  # NumPy 1
        from numpy.core._multiarray_umath import __cpu_dispatch__, __cpu_features__
    return " ".join(name for name in __cpu_dispatch__ if __cpu_features__.get(name))


HWCAPS = "glibc.cpu.hwcaps=-AVX2,-FMA,-FMA4,-AVX512F,-AVX2_Usable,-FMA_Usable"
C_LIBRARY = {"GLIBC_TUNABLES": HWCAPS}
NUMPY = {"NPY_DISABLE_CPU_FEATURES": dispatched()} if dispatched() else {}
OLDEST = {"NUMBA_CPU_NAME": "x86-64" if X86 else "generic", "NUMBA_CPU_FEATURES": ""}
LIBRARIES = {**C_LIBRARY, **NUMPY, "OPENBLAS_CORETYPE": "Prescott" if X86 else "ARMV8"}

SETTINGS = {
    "as it is": {},
    "an old C library": C_LIBRARY,
    "BLAS of Haswell": {"OPENBLAS_CORETYPE": "Haswell" if X86 else "ARMV8"},
    "BLAS of Prescott": {"OPENBLAS_CORETYPE": "Prescott" if X86 else "NEOVERSEN1"},
    "NumPy without dispatch": NUMPY,
    "one thread": {"NUMBA_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"},
    "the oldest processor": OLDEST,
    "all at once": {**LIBRARIES, **OLDEST},
}
if X86:
    SETTINGS["Haswell"] = {"NUMBA_CPU_NAME": "haswell", "NUMBA_CPU_FEATURES": "+avx2,+fma"}


# functions of which every processor has the same, though some call the C library for them
EXACT = {"ceil", "floor", "trunc", "rint", "sqrt", "fabs", "copysign", "fmin", "fmax"}


def run(setting, *arguments, cache=None):
    variables = {} if cache is None else {"NUMBA_CACHE_DIR": str(cache)}
    ours = ("GLIBC_TUNABLES", "OPENBLAS_", "NPY_", "NUMBA_CPU_", "NUMBA_DISABLE_JIT")
    with pytest.MonkeyPatch.context() as patch:
        for name in filter(lambda name: name.startswith(ours), [*os.environ]):
            patch.delenv(name)
        return json.loads(printed(PROGRAM, *arguments, **variables, **setting))


def differing(digests, usual):
    names = usual.keys() | digests.keys()
    return sorted(name for name in names if digests.get(name) != usual.get(name))


def of_every_kind(labels):
    return {"chaos", "undetermined"} & labels and any(label[0].isdigit() for label in labels)


@pytest.fixture(scope="module")
def usual():
    return run({}, "usual")


@pytest.fixture(scope="module")
def oldest(tmp_path_factory):
    """Return the digests of the oldest processor with old libraries, and what it has compiled."""
    cache = tmp_path_factory.mktemp("oldest")
    return run({**LIBRARIES, **OLDEST}, "--code", "usual", cache=cache)


def test_libraries_do_not_matter(usual):
    assert len(usual) > 12  # a digest of each dataset
    assert of_every_kind(set(usual["usual: labels"]))
    assert differing(run(LIBRARIES, "usual"), usual) == []


def test_the_processor_does_not_matter(oldest, usual):
    assert differing(oldest, {**usual, "code": oldest["code"]}) == []


def test_compiled_code_calls_no_library_for_a_number_and_contracts_nothing(oldest):
    """No sine and no power, but what rounds in one way only.

    Should log10 appear: an assignment of a slice may raise, and Numba writes the sizes into its
    message by log10. A loop over the numbers compiles faster, too.
    """
    code = oldest["code"]
    assert code["modules"] > 30  # of entries, each with all that it calls
    assert code["loops"] >= 2  # over lanes, to run and to judge
    assert set(code["called"]) <= EXACT
    functions = {name.split(".")[1] for name in code["intrinsics"]}
    inexact = {"sin", "cos", "tan", "pow", "powi", "exp", "exp2", "log", "log2", "log10", "sincos"}
    assert not functions & (inexact | {"fma", "fmuladd"})
    assert "sqrt" in functions
    # no operation may be contracted or reordered
    assert code["flags"] == code["fused on ARM64"] == []


def test_what_is_contracted_would_be_seen():
    """On ARM64 a product and a sum that may be fused are."""
    text = dedent("""
    define double @run_lanes(double %a, double %b, double %c) {
      %m = fmul contract double %a, %b
      %s = fadd contract double %m, %c
      %p = call double @cbrt(double %s)
      ret double %p
    }
    declare double @cbrt(double)
    """)
    code = orbits_of_all_kinds.code([text])
    assert code["flags"]
    assert code["fused on ARM64"] == ["fmadd"]
    assert code["called"] == ["cbrt"]
    strict = orbits_of_all_kinds.code([text.replace("contract ", "")])
    assert strict["flags"] == strict["fused on ARM64"] == []


def test_every_nan_is_the_same():
    """0 / 0 has one sign on x86-64 and the other on ARM64."""
    document = {"system": "tmd", "vary": {"P": [0.0, 800.0]}, "record": {"want": ["energy"]}}
    scan = load_scan(document)
    arrays = Computer(scan).block(Block(0, ((0, 2),)))["reduction"]
    assert np.isnan(arrays).ravel().tolist() == [True, False]
    assert not np.signbit(arrays[0]).any()


@pytest.fixture(scope="module")
def everything():
    return run({}, *CASES)


@pytest.fixture(scope="module")
def caches(tmp_path_factory):
    return {name: tmp_path_factory.mktemp("cache") for name in ("x86-64", "generic", "haswell")}


@pytest.mark.long
@pytest.mark.parametrize("setting", list(SETTINGS)[1:])
def test_no_setting_changes_a_bit(setting, everything, caches):
    if not SETTINGS[setting]:
        pytest.skip("NumPy has one code for this processor")
    cache = caches.get(SETTINGS[setting].get("NUMBA_CPU_NAME"))
    assert differing(run(SETTINGS[setting], *CASES, cache=cache), everything) == []


@pytest.mark.long
def test_the_cases_are_not_all_alike(everything):
    labels = {label for name in everything if name.endswith("labels") for label in everything[name]}
    assert of_every_kind(labels)
    assert {"T,0", "chaos"} <= labels
    assert len(everything) > 150
