"""The kernels' own functions: errors below one unit in the last place, the same bits uncompiled."""

import json
import os
import subprocess
import sys
from math import inf, nan

import mpmath
import numpy as np
import pytest
from support import REPO

from nlds_vines.kernels.numerics import elementary

DRAWN = 3000
MP = mpmath.MPContext()
MP.prec = 140

FUNCTIONS = ("cosine", "sine", "exp", "log", "log10", "fifth_root")


def own(name, x):
    if name in ("cosine", "sine"):
        return elementary.cos_sin_of_turn(x)[name == "sine"]
    return getattr(elementary, name)(x)


def exact(name, x):
    x = MP.mpf(x)
    if name in ("cosine", "sine"):
        return (MP.cos if name == "cosine" else MP.sin)(2 * MP.pi * x)
    return MP.root(x, 5) if name == "fifth_root" else getattr(MP, name)(x)


def arguments(name):
    """Return numbers over the whole range of a function, more where it is used."""
    draw = np.random.default_rng(5).uniform
    if name in ("cosine", "sine"):
        eighths = np.arange(1, 65) / 64
        near = [eighths * (1 + 1e-15), eighths - 1e-9, eighths + 3e-5 * draw(-1, 1, 64)]
        drawn = [draw(0, 1, DRAWN), 10 ** draw(-300, 6, DRAWN), *near]
    elif name == "exp":
        drawn = [draw(-708, 709.78, DRAWN), draw(-40, 2, DRAWN), draw(-1e-3, 1e-3, DRAWN)]
    else:
        low = 2.0 ** np.arange(-1074, 1024, 7)
        drawn = [10 ** draw(-307, 308, DRAWN), draw(0.5, 2, DRAWN), 1 + draw(-1e-7, 1e-7, 999), low]
    return [float(x) for x in np.concatenate(drawn)]


@pytest.mark.kernels
@pytest.mark.parametrize("name", FUNCTIONS)
def test_errors_are_below_one_unit_in_the_last_place(name):
    allowed = {"log10": 2.0, "fifth_root": 0.51}.get(name, 0.85)
    for x in arguments(name):
        values, true = own(name, x), exact(name, x)
        assert abs(values - true) <= allowed * np.spacing(abs(float(true))), x


def test_whole_quarters_of_a_turn_are_exact():
    for i, there in enumerate([(1, 0), (0, 1), (-1, 0), (0, -1)] * 9):
        assert elementary.cos_sin_of_turn(0.25 * i) == there


@pytest.mark.kernels
def test_ends_of_the_ranges_and_numbers_below_the_normal_ones():
    for x, there in ((0.0, 1.0), (710.0, inf), (inf, inf), (-746.0, 0.0), (-inf, 0.0)):
        assert elementary.exp(x) == there
    assert elementary.exp(-745.0) == 5e-324
    for x, there in ((1.0, 0.0), (0.0, -inf), (inf, inf)):
        assert elementary.log(x) == elementary.log10(x) == there
    for x, there in ((0.0, 0.0), (1.0, 1.0), (32.0, 2.0), (inf, inf), (2.0**1020, 2.0**204)):
        assert elementary.fifth_root(x) == there
    for f, x in ((elementary.exp, nan), (elementary.log, nan), (elementary.fifth_root, nan)):
        assert np.isnan(f(x))
    assert np.isnan(elementary.log(-1.0))
    assert np.isnan(elementary.fifth_root(-1.0))
    # a result below the normal numbers is rounded twice at most
    for x in np.random.default_rng(6).uniform(-745, -708, 500):
        assert abs(elementary.exp(x) - MP.exp(MP.mpf(x))) <= 1.5 * 5e-324 + 1.2e-16 * np.exp(x)


PROGRAM = """
import json, sys
from test_elementary import own
from test_impact_variations import make_arc, random_impacts
printed = {name: [float(own(name, x)).hex() for x in values]
           for name, values in json.load(sys.stdin).items()}
for i, impact in enumerate(random_impacts(6, make_arc())):
    printed[f"variations {i}"] = [x.hex() for x in impact.carried(make_arc()).tolist()]
json.dump(printed, sys.stdout)
"""


@pytest.mark.slow("two processes, of which one compiles short impacts")
def test_compiled_and_uncompiled_give_the_same_bits():
    """Of the functions, and of variations through short impacts."""
    argument = json.dumps({name: arguments(name)[::5] for name in FUNCTIONS})
    outputs = []
    for disabled in "01":
        paths = os.pathsep.join([str(REPO), str(REPO / "tests"), str(REPO / "tests" / "kernels")])
        done = subprocess.run(
            [sys.executable, "-W", "ignore", "-c", PROGRAM], input=argument, capture_output=True,
            text=True, check=False,
            env={**os.environ, "PYTHONPATH": paths, "NUMBA_DISABLE_JIT": disabled},
        )  # fmt: skip
        assert done.returncode == 0, done.stderr
        outputs.append(json.loads(done.stdout))
    assert outputs[0] == outputs[1]
    assert len(outputs[0]["variations 5"]) == 16
