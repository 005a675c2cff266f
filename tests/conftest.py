"""In which order the files run: those that take minutes first, so that none is alone at the end."""

from collections import Counter
from pathlib import Path

import pytest

FIRST = (
    "contract/test_plain.py",  # compiles nothing: meanwhile others compile what many files need
    "property/test_no_missed_impact.py",
    "contract/test_same_bits.py",
    "continuation/test_closed_forms.py",
    "kernels/test_contact_laws.py",
    "contract/test_specialisation.py",
    "property/test_limit.py",
    "contract/test_determinism.py",
    "continuation/test_branches.py",
    "orbits/test_attractors.py",
)
"""Files below `tests` that take a minute or more."""

TESTS = Path(__file__).parent


def pytest_collection_modifyitems(items):
    """Put the files of `FIRST` first, then those of many tests; pytest-xdist hands out files."""
    if missing := [name for name in FIRST if not (TESTS / name).exists()]:
        raise pytest.UsageError(f"{__file__} names files that are not there: {missing}")
    rank = {TESTS / name: place for place, name in enumerate(FIRST)}
    count = Counter(item.path for item in items)
    items.sort(key=lambda item: (rank.get(item.path, len(FIRST)), -count[item.path], item.path))
