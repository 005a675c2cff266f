"""The files `plain_*.py`, and tests marked `plain`, run kernels without the compiler.

They note what no other test notes of a scene, or call kernels one by one: to compile that would
take minutes, and plain Python, equal to the last bit, takes seconds.
"""

import os
import subprocess
import sys
from pathlib import Path

import pytest
from support import REPO

FILES = sorted(path.relative_to(REPO).as_posix() for path in REPO.glob("tests/**/plain_*.py"))

LONG = (
    "tests/kernels/plain_host_impact.py",
    "tests/kernels/plain_host_energies.py",
    "tests/kernels/plain_host_repetition.py",
    "tests/engine/plain_load_flight.py",
    "tests/kernels/plain_verdict.py",
    "tests/kernels/plain_response.py",
    "tests/kernels/plain_impact.py",
    "tests/property/plain_laws.py",
    "tests/engine/plain_repetition.py",
    "tests/continuation/plain_derivatives.py",
    "tests/kernels/plain_contact_laws.py",
    "tests/benchmarks/plain_costs.py",
    "tests/benchmarks/plain_speed.py",
    "tests/continuation/plain_limits.py",
    "tests/kernels/plain_exact.py",
    "tests/kernels/plain_numerics.py",
    "tests/bifurcation/plain_sweeps.py",
)
"""Those that take seconds, for whoever changes kernels: a group has every fifth of them."""

LONGEST = ("tests/engine/plain_kept_state.py", "tests/property/plain_load_frames.py")
"""Those that take a minute or more: all kinds under all laws."""

MARKED = [
    path.relative_to(REPO).as_posix()
    for path in sorted(REPO.glob("tests/**/test_*.py"))
    if path != Path(__file__) and "pytest.mark.plain" in path.read_text("utf-8")
]

SHORT = [file for file in FILES if file not in LONG + LONGEST]


def test_the_long_ones_exist():
    assert set(FILES) > {*LONG, *LONGEST}


@pytest.mark.slow("as many seconds as thousands of steps of plain Python take")
@pytest.mark.parametrize(
    "files",
    [
        *(pytest.param(SHORT[i::2], id=f"short {i}") for i in range(2)),
        *(
            pytest.param(
                ["-m", "plain", *MARKED[i::2]], id=f"marked {i}", marks=pytest.mark.kernels
            )
            for i in range(2)
        ),
        *(pytest.param(LONG[i::5], id=f"long {i}", marks=pytest.mark.kernels) for i in range(5)),
        *(pytest.param([file], id=file, marks=pytest.mark.long) for file in LONGEST),
    ],
)
def test_without_the_compiler(files):
    """Run files in a process whose kernels are plain Python."""
    options = ["-p", "no:cacheprovider", "-o", "addopts=", "-q", "--tb=short"]
    options += ["-W", "ignore::RuntimeWarning"]  # NumPy warns where compiled kernels do not
    done = subprocess.run(
        [sys.executable, "-m", "pytest", *options, *files], cwd=REPO, capture_output=True,
        env={**os.environ, "NUMBA_DISABLE_JIT": "1"}, text=True, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stdout
