"""What a result prints: a few lines, however large it is."""

import dataclasses
import importlib
import inspect
import re
from pathlib import Path

import numpy as np
import pytest

import nlds_vines as nv
from nlds_vines.archives.archive import ArchivePath
from nlds_vines.archives.representation import WIDTH
from nlds_vines.bifurcation.response_curves import ResponseCurve, ResponseCurves, load_curves
from nlds_vines.loads.result import PEAKS, LoadScan, ResponseHistories, ResponseHistory
from nlds_vines.model.quantities import SHARES, WAYS
from nlds_vines.model.setting import Request
from nlds_vines.model.slow_manifold import FrequencyResponse
from nlds_vines.model.system import System

MOST = 6
"""Lines that a result may print."""

MANY = 100_000

PATH = ArchivePath("x.h5")


def named_in(module, annotation):
    for name in re.findall(r"\w+", str(annotation)):
        value = getattr(module, name, None)
        if inspect.isclass(value) and value.__module__.startswith("nlds_vines."):
            yield value


def annotations_of(value):
    if not inspect.isclass(value):
        yield value.__annotations__.get("return", "")
        return
    yield from inspect.get_annotations(value).values()
    for name, member in vars(value).items():
        member = getattr(member, "fget", getattr(member, "func", member))
        if not name.startswith("_") and inspect.isfunction(member):
            yield member.__annotations__.get("return", "")


def results():
    stub = (Path(nv.__path__[0]) / "__init__.pyi").read_text()
    exported = re.findall(r"^from (\S+) import (\w+) as", stub, re.MULTILINE)
    left = [getattr(importlib.import_module(module), name) for module, name in exported]
    classes = set()
    while left:
        value = left.pop()
        if value in classes or (inspect.isclass(value) and issubclass(value, (Request, System))):
            continue
        classes.add(value)
        for base in value.__mro__ if inspect.isclass(value) else [value]:
            if base.__module__.startswith("nlds_vines."):
                module = importlib.import_module(base.__module__)
                for annotation in annotations_of(base):
                    left += named_in(module, annotation)
    return {value for value in classes if inspect.isclass(value)}


def holds_much(kind):
    annotations = inspect.get_annotations(kind).values()
    return any(
        re.search(r"ndarray|Mapping|tuple\[\w+, \.\.\.\]|list\[", str(a)) for a in annotations
    )


def is_generated(kind):
    """Return True if a dataclass or a named tuple prints all that it holds."""
    if dataclasses.is_dataclass(kind):
        return kind.__dataclass_params__.repr
    return getattr(kind.__repr__, "__module__", None) == "collections"


def test_every_result_has_a_short_form_of_its_own():
    """Neither the form that dataclasses make of all that they hold, nor that of a tuple."""
    kinds = results()
    assert {
        ResponseHistories,
        LoadScan,
        ResponseCurves,
        ResponseHistory,
        ResponseCurve,
        FrequencyResponse,
    } <= kinds
    generated = {kind.__name__ for kind in kinds if holds_much(kind) and is_generated(kind)}
    assert generated == {"Dataset"}  # which describes a column, in a few words


def fall(count):
    time = np.linspace(0.0, 60.0, count)
    numbers = {f"last_{100 * share:g}": 1.0 for share in SHARES}
    numbers |= {**dict.fromkeys(PEAKS, 1.0), "E1max": 1.0, "x1_rms": 0.1}
    numbers |= {f"share_{path}": 0.3 for path in WAYS}
    return ResponseHistory(time, time, time, time, time, time, dict.fromkeys(WAYS, time), numbers)


def made_up():
    names = ["none", "tmd", "ssbl", *(f"ssul-set{i}" for i in range(1, 7))]
    request = nv.load_response_history({"systems": names, "load": {"impulse": 300.0}})
    yield fall(MANY)
    yield ResponseHistories(PATH, request, {name: fall(2000) for name in names})
    axes = {"impulse": {"start": 1.0, "stop": 300.0, "num": 500}}
    many = nv.load_response_history({"systems": names, "load": {"impulse": 300.0}, "vary": axes})
    values = np.ones((len(names), 500))
    yield LoadScan(PATH, many, {"E1max": values, "x1_max": values}, np.zeros_like(values, int))
    omega = {"omega": {"start": 5.0, "stop": 8.0, "num": 100}}
    page = load_curves({"vary": omega, "curves": [{"system": name} for name in names]})
    numbers = dict.fromkeys(("E1max", "E2max"), np.ones((MANY, 1)))
    curves = [ResponseCurve(case.title, case, numbers) for case in page.cases]
    yield curves[0]
    yield ResponseCurves(PATH, page, tuple(curves))
    yield nv.slow_manifold(nv.load_system("vi-nes"))
    yield nv.slow_manifold(nv.load_system("vi-nes")).response()


@pytest.mark.parametrize("place", range(7))
def test_large_results_print_a_few_lines(place):
    text = str([*made_up()][place])
    lines = text.splitlines()
    assert len(lines) <= MOST
    assert all(len(line) <= WIDTH + 100 for line in lines)
    assert len(text) > 20
