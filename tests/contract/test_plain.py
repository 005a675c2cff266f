"""The files `plain_*.py` hold tests of kernels that run without the compiler.

They note what no other test notes of a scene, or call kernels one by one: to compile that would
take minutes, and plain Python, equal to the last bit, takes seconds.
"""

import os
import subprocess
import sys

import pytest
from support import REPO

FILES = sorted(path.relative_to(REPO).as_posix() for path in REPO.glob("tests/*/plain_*.py"))


@pytest.mark.parametrize("file", FILES)
def test_without_the_compiler(file):
    options = ["-p", "no:cacheprovider", "-o", "addopts=", "-q", "--tb=short"]
    options += ["-W", "ignore::RuntimeWarning"]  # NumPy warns where compiled kernels do not
    found = subprocess.run(
        [sys.executable, "-m", "pytest", *options, file], cwd=REPO, capture_output=True,
        env={**os.environ, "NUMBA_DISABLE_JIT": "1"}, text=True, check=False,
    )  # fmt: skip
    assert found.returncode == 0, found.stdout
