"""A dry run of each command says what the run would do, and writes nothing."""

import shlex

import pytest

TOLD = {
    "accuracy": ["ssul-set6: exact\nssul-set6: rk4\nssul-set6: SciPy DOP853\n"],
    "continuation --all -o b.h5": ["100 random starts"],
    "response-history --impulse 100": ["Tuned mass damper"],
    "portrait --system tmd --transient 0 --periods 4 --start rest": [
        "4 periods from rest; 4096 states", "picture: portrait.png",
    ],
    "portrait --start -0.03,0.1,.2,0": ["from (-0.03, 0.1, 0.2, 0.0)"],
    "portrait --start -.03,0.1,0,0": ["from (-0.03, 0.1, 0.0, 0.0)"],
    "tuning --band 5:8:61 --plot a.png": ["61 values of omega", "k2 from 10 to 10000, logarithmic"],
    "tuning --free V": ["V from 0 to 0.5 (does not enter the dynamics"],
}  # fmt: skip
"""What a command line says, by its words."""


@pytest.mark.parametrize("line", TOLD)
def test_a_dry_run_says_what_would_be_done_and_writes_nothing(line, here, answer):
    text = answer(*shlex.split(line), "--dry-run")
    assert all(words in text for words in TOLD[line]), text
    assert list(here.iterdir()) == []
