"""Numbers in words: sizes, times and paces as they are printed."""

import re

import pytest

from nlds_vines.runs.progress import brief, duration, size


@pytest.mark.parametrize(
    ("seconds", "words"),
    [
        (0.0123, "0.012 s"), (1.0, "1 s"), (9.96, "10 s"), (99.6, "100 s"), (115.0, "115 s"),
        (119.7, "2 min"), (120.0, "2 min"), (3599.0, "60 min"), (7190.0, "2.0 h"), (1e5, "27.8 h"),
    ],
)  # fmt: skip
def test_a_time_to_go(seconds, words):
    assert duration(seconds) == words


@pytest.mark.parametrize(
    ("count", "words"),
    [
        (0, "0 B"), (999, "999 B"), (1000, "1 kB"), (999_600, "1 MB"), (1_234_567, "1.23 MB"),
        (999_499, "999 kB"), (5 * 10**15, "5000 TB"),
    ],
)  # fmt: skip
def test_a_size(count, words):
    assert size(count) == words


def test_no_printed_number_is_in_powers_of_ten():
    for exponent in range(-20, 60):
        value = 1.2345 * 10 ** (exponent / 8)
        for text in (brief(value), size(round(value)), duration(value)):
            assert re.fullmatch(r"[0-9.]+( [a-zA-Z]+)?", text), text
