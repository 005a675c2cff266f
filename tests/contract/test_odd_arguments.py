"""Odd values for every argument of every public function: one line, and never a bare error."""

import inspect
import re
import warnings
from fractions import Fraction

import numpy as np
import pytest
from made_up import make_scan, write

import nlds_vines as nv
from nlds_vines.engine import host_engine, kind_engine, simulation
from nlds_vines.portrait import run as portrait_run
from nlds_vines.runs.store import BlockStore

pytestmark = pytest.mark.slow("thousands of calls")


class Computed(Exception):
    """A request was right: what would be computed is none of these tests."""


class Hostile:
    """An object that does not say what it is."""

    def __repr__(self):
        raise RuntimeError("no words")


VALUES = {
    "array": np.ones(3), "array of no dimension": np.array(1.0), "matrix": np.zeros((2, 2)),
    "masked array": np.ma.masked_array([1.0, 2.0], [0, 1]), "empty array": np.array([]),
    "texts": np.array(["a", "b"]), "None": None, "True": True, "bytes": b"x", "nan": float("nan"),
    "-1": -1, "1e308": 1e308, "huge": 10**400, "more than 4300 digits": 10**5000,
    "NumPy's": np.float64("nan"), "complex": 1j, "fraction": Fraction(1, 3), "empty text": "",
    "word": "word", "null": "a\0b", "lines": "a\nb", "long": "x" * 3000, "list": [None],
    "lists": [[]], "four": (10**400, 1, 1, 1), "table": {"omega": np.linspace(6.0, 7.0, 3)},
    "tables": {"omega": {"start": np.ones(2), "stop": 3, "num": 3}}, "keys": {1: 2},
    "object": object(), "hostile": Hostile(), "class": dict, "set": {1, 2},
}  # fmt: skip

SYSTEM = {"m1": 1000.0, "f1": 1.0, "zeta1": 0.02, "P": 800.0, "omega": 6.28}
STOREY = {"masses": [1.0, 1.0], "stiffnesses": [100.0, 100.0]}

CALLS = {
    "scan": {"source": "ssul-set6"}, "load_scan": {"source": "ssul-set6"},
    "response_curves": {}, "continue_branch": {"source": "ssul-set6"},
    "load_continuation": {"source": "ssul-set6"}, "response_history": {"source": "tmd"},
    "load_response_history": {"source": "tmd"}, "tune": {"source": "tmd"},
    "load_tuning": {"source": "tmd"}, "transient_lifetimes": {"system": "ssul-set6"},
    "orbit_portrait": {"source": "ssul-set6"}, "simulate": {"system": "ssul-set6", "periods": 2},
    "classify": {"system": "ssul-set6"}, "load_system": {"name_or_path": "tmd"},
    "System": {"kind": "none", "parameters": SYSTEM}, "Host": {"M": [[2.0]], "K": [[300.0]]},
    "shear_frame": STOREY, "chain": STOREY, "beam": {"length": 1.0, "stiffness": 1.0},
    "Damper": {"name": "cell", "attached_to": "roof", "m": 1.0, "k": 3.0},
    "Wall": {"gap": 0.1, "K": 1e5}, "Spring": {"k3": 1e5}, "slow_manifold": {"system": "ssul-set6"},
    "read": {"path": "a.h5"}, "open_archive": {"path": "a.h5"}, "orbit_of": {"archive": "a.h5"},
    "basin_measures": {"archive": "a.h5"}, "ensemble_of": {"archive": "a.h5"},
    "panels": {"archive": "a.h5"}, "load_portrait": {"source": "ssul-set6"},
}  # fmt: skip
"""Public functions with arguments that are right; one at a time is replaced."""

KEYWORDS = ("set", "vary", "start", "sampling", "record", "search", "load", "title", "omega")
"""What a function that takes any keyword is given."""


@pytest.fixture(autouse=True)
def nothing_is_computed(here, monkeypatch):
    write("a.h5", make_scan(("energy", "regime")))

    def stop(*_, **__):
        raise Computed

    class Kernels:
        run = stop

    monkeypatch.setattr(BlockStore, "carry_out", stop)
    monkeypatch.setattr(kind_engine.Beginning, "_run", stop)
    monkeypatch.setattr(host_engine, "follow_host", stop)
    for engine in (kind_engine.KindEngine, host_engine.HostEngine):
        monkeypatch.setattr(engine, "runner", lambda *_, **__: Kernels())
    monkeypatch.setattr(portrait_run, "followed", stop)


def names_of(function):
    """Return the names of the arguments that are replaced."""
    every = inspect.signature(function).parameters.values()
    names = [one.name for one in every if one.kind not in (one.VAR_KEYWORD, one.VAR_POSITIONAL)]
    if any(one.kind == one.VAR_KEYWORD for one in every):
        names += [name for name in KEYWORDS if name not in names]
    return names


def fault_of(function, arguments):
    """Return how a call with odd arguments breaks the rule; empty if it does not."""
    every = inspect.signature(function).parameters.values()
    first = [one.name for one in every if one.kind == one.POSITIONAL_ONLY]
    others = {name: value for name, value in arguments.items() if name not in first}
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            function(*(arguments[name] for name in first if name in arguments), **others)
    except (Computed, nv.IntegrationError):
        pass
    except nv.RequestError as error:
        if "\n" in str(error) or len(str(error)) > 2100:
            return f"{len(str(error))} characters: {str(error)[:80]!r}"
    except TypeError as error:
        if not re.search(r"unexpected keyword|multiple values|required positional", str(error)):
            return repr(error)
    except Exception as error:
        return repr(error)[:200]
    return ""


@pytest.mark.parametrize("name", CALLS)
def test_odd_arguments_are_refused_in_one_line(name):
    function, usual, faults = getattr(nv, name), CALLS[name], []
    for argument in names_of(function):
        for words, value in VALUES.items():
            if fault := fault_of(function, {**usual, argument: value}):
                faults.append(f"{argument} = {words}: {fault}")
    assert faults == []


MISTAKES = {
    "an axis as keyword": (lambda: nv.scan("tmd", omega=np.linspace(6, 7, 3)), "vary={.omega."),
    "a number as keyword": (lambda: nv.scan("ssul-set6", P=700.0), "set={'P': ...}"),
    "a setting as keyword": (lambda: nv.scan("ssul-set6", transient=20), "sampling={'transient'"),
    "a name that is none": (lambda: nv.simulate("ssul-set7", 3), "did you mean 'ssul-set"),
    "an axis as a number": (lambda: nv.scan("tmd", vary={"omega": 7.0}), "omega"),
    "a name as axis": (lambda: nv.scan("tmd", vary="omega"), "vary = 'omega' must be a table"),
    "a record as a set": (lambda: nv.scan("tmd", record={"energy"}), "record"),
    "periods as a float": (lambda: nv.simulate("tmd", 100.0), "periods = 100.0 must be a whole"),
    "a system as a dict": (lambda: nv.simulate({"m1": 1.0}, 3), "must be a System, a name or"),
    "an array for resume": (lambda: nv.scan("tmd", resume=np.ones(2)), "resume = .* true or false"),
    "True as executor": (lambda: nv.scan("tmd", executor=True), "executor = True must be"),
    "a huge start": (lambda: nv.simulate("tmd", 3, start=10**400), "start = .* 4 finite numbers"),
    "masked values": (
        lambda: nv.scan("tmd", vary={"omega": np.ma.masked_greater([6.0, 7.0, 9.0], 8.0)}),
        "omega has masked entries",
    ),
    "masked samples": (
        lambda: nv.scan("tmd", samples={"omega": np.ma.masked_greater([6.0, 9.0], 8.0)}),
        "omega has masked entries",
    ),
}  # fmt: skip


@pytest.mark.parametrize("words", MISTAKES)
def test_plain_mistakes_are_one_line_with_a_remedy(words, error_of):
    call, message = MISTAKES[words]
    assert re.search(message, error_of(call))


def test_more_periods_than_memory_holds_are_refused(error_of, monkeypatch):
    monkeypatch.setattr(simulation, "free_memory", lambda: 2 * 10**9)
    line = error_of(nv.simulate, "ssul-set6", 10**8, quiet=True)
    assert re.search(r"periods = 100000000: .* need 35.2 GB of memory, 2 GB are free", line)
    with pytest.raises(Computed):
        nv.simulate("ssul-set6", 3, transient=10**8, quiet=True)
