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
    "tuning --band 5:8:61 --plot a.png": [
        "61 values of omega", "k2 from 10 to 10000 N/m, logarithmic",
        "omega = 5 to 8 rad/s (0.7958 to 1.273 Hz), 61 values",
    ],
    "tuning --free V": ["V from 0 to 0.5 m (does not enter the dynamics"],
    "bifurcation --vary f=5:8:3": ["f = 5 to 8 Hz (31.42 to 50.27 rad/s), 3 values"],
    "bifurcation --vary f1=1:2:3": ["f1 = 1 to 2 Hz (6.283 to 12.57 rad/s), 3 values"],
    "response-curves": ["omega = 4.5 to 8 rad/s (0.7162 to 1.273 Hz), 351 values"],
    "continuation --along f=0.8:1.2 --plane P=500:900": [
        "f from 0.8 to 1.2 Hz (5.027 to 7.54 rad/s)", "P from 500 to 900 N"
    ],
}  # fmt: skip
"""What a command line says, by its words."""


@pytest.mark.parametrize("line", TOLD)
def test_a_dry_run_says_what_would_be_done_and_writes_nothing(line, here, answer):
    text = answer(*shlex.split(line), "--dry-run")
    assert all(words in text for words in TOLD[line]), text
    assert list(here.iterdir()) == []
