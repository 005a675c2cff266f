"""How kernels are compiled: for whom, how often, what rests meanwhile; what laws say is heard."""

import gc
import re
from typing import Any, NamedTuple

import numba
import pytest
from commands import printed

from nlds_vines.kernels.cells import lanes
from nlds_vines.kernels.numerics import stored_code
from nlds_vines.kernels.numerics.compiling import Inner, jit, told_of_compilations
from nlds_vines.kernels.numerics.deciding import is_a, same_sort
from nlds_vines.kernels.numerics.stored_code import KERNELS

pytestmark = pytest.mark.skipif(numba.config.DISABLE_JIT, reason="nothing is compiled")


@jit
def doubled(x):
    return x + x


class Pair(NamedTuple):
    """Two numbers, the second of which may be absent."""

    x: Any
    y: Any


class Alone(NamedTuple):
    x: float


@jit
def last_of(part):
    if is_a(part, Alone):
        return doubled(part.x), None
    x, y, _, _ = part.x, part.y, 0.0, 0.0
    if y is None:
        return (doubled(x),)
    return doubled(part.y)


@jit
def both_of(part, other):
    if part is not None and other is not None and same_sort(part, other):
        return part.x + other.x
    return None


@jit(entry=True)
def last_doubled(part):
    return last_of(part), both_of(part, part), both_of(part, None), both_of(part, Alone(1.0))


@jit(entry=True)
def is_of_what_is_no_argument(x):
    return is_a(doubled(x), Alone)


NEXT = "def f(x):\n    return x + 1"


def kernel(text):
    """Return a kernel that is compiled now: nothing on the disk knows it."""
    space = {"jit": jit, "doubled": doubled}
    exec(text, space)
    space["f"].__module__ = "nlds_vines.kernels.made_up"
    return jit(space["f"], entry=True)


def test_kernels_that_kernels_call_have_no_wrapper_and_python_calls_them_all_the_same():
    assert isinstance(doubled, Inner)
    assert doubled(16.0) == 32.0
    assert not doubled.overloads or all(one.entry_point for one in doubled.overloads.values())
    assert doubled.entry is doubled.entry
    assert not isinstance(doubled.entry, Inner)
    for entry in (lanes.run_lanes, lanes.judge_lanes):
        assert not isinstance(entry, Inner)


def test_types_of_arguments_and_of_their_fields_decide_branches_of_other_types():
    """Of an absent part not even the code is typed. Notices: a field that is not looked at."""
    assert last_doubled(Alone(2.0)) == ((4.0, None), 4.0, None, 3.0)
    assert last_doubled(Pair(2.0, None)) == ((4.0,), 4.0, None, None)
    assert last_doubled(Pair(2.0, 3.0)) == (6.0, 4.0, None, None)


@pytest.mark.kernels
def test_what_types_do_not_decide_is_an_error():
    with pytest.raises(numba.TypingError):
        is_of_what_is_no_argument(2.0)


@pytest.mark.kernels
def test_a_number_that_is_known_when_compiling_is_a_number_like_any_other():
    """Notices: a kernel compiled for each constant that it is called with."""
    kernels = []
    made = kernel("def f():\n    return doubled(2.5) + doubled(3.5) + doubled(4.5)")
    before = len(doubled.overloads)
    with told_of_compilations(kernels.append):
        assert made() == 21.0
    assert len(doubled.overloads) - before <= 1


@pytest.mark.kernels
def test_the_collector_rests_during_each_outermost_compilation_and_works_afterwards():
    seen = []
    made = kernel(NEXT)
    with told_of_compilations(*2 * [lambda kernel: seen.append(gc.isenabled())]):
        assert made(1) == 2
        assert gc.isenabled()
        assert made(2) == 3
    assert seen == [True, True]  # before it rests, and after
    # nested compilations are one pause
    flags = []
    made = kernel("@jit\ndef g(x):\n    return x + 1\ndef f(x):\n    return g(x)")
    with told_of_compilations(lambda one: flags.append(gc.isenabled())):
        assert made(1) == 2
    assert flags == [True, False]
    assert gc.isenabled()
    # an error of the compiler lets it work again
    with pytest.raises(numba.TypingError):
        kernel("def f(x):\n    return x + 'a'")(1)
    assert gc.isenabled()
    # whoever ends a compilation before it begins stops nothing else
    made = kernel(NEXT)

    def refuse(kernel):
        raise RuntimeError("no memory")

    with told_of_compilations(refuse), pytest.raises(RuntimeError, match="no memory"):
        made(1)
    assert gc.isenabled()
    assert made(1) == 2
    # a collector that is off stays off
    gc.disable()
    try:
        assert kernel(NEXT)(1) == 2
        assert not gc.isenabled()
    finally:
        gc.enable()


def test_what_others_compile_is_their_business():
    kernels, theirs = [], numba.njit(lambda x: max(abs(x), round(2.5)))
    with told_of_compilations(kernels.append):
        assert theirs(1) == 2
    assert kernels == []


PLAIN = """
import hashlib, sys
from numba.core.compiler import CompileResult
if sys.argv[1] == "plain":
    private = vars(CompileResult)["_rebuild"]
    del CompileResult._rebuild
from nlds_vines.kernels.numerics import compiling
if sys.argv[1] == "plain":
    CompileResult._rebuild = private
import nlds_vines as nv
assert compiling.LINKED == (sys.argv[1] == "linked")
compiled = []
with compiling.told_of_compilations(compiled.append):
    orbit = nv.simulate(nv.load_system(sys.argv[2]), periods=20)
print(hashlib.sha256(orbit.section.tobytes()).hexdigest(), bool(compiled))
"""


@pytest.mark.kernels
@pytest.mark.parametrize("system", ["tmd", pytest.param("ssul-set6", marks=pytest.mark.long)])
def test_where_the_inside_of_numba_is_another_one_its_own_cache_keeps_kernels(system, tmp_path):
    """To the same bits; the next process compiles nothing."""
    outputs = {}
    for run in ("linked", "plain", "plain again"):
        how = run.split()[0]
        cache = {"NUMBA_CACHE_DIR": str(tmp_path / how)}
        outputs[run] = printed("-c", PLAIN, how, system, **cache).split()
    assert outputs["linked"] == outputs["plain"]
    assert outputs["plain again"] == [outputs["plain"][0], "False"]


def test_the_cache_of_numba_belongs_to_the_sources_of_all_kernels(tmp_path, monkeypatch):
    monkeypatch.setattr(stored_code, "KERNELS", tmp_path)
    monkeypatch.setattr(stored_code, "folder", lambda: tmp_path)
    folder_of_numba = stored_code.folder_of_numba.__wrapped__
    (tmp_path / "inner.py").write_text("GAP = 1")
    former = folder_of_numba()
    assert folder_of_numba() == former
    former.mkdir()
    (tmp_path / "inner.py").write_text("GAP = 2")
    assert folder_of_numba() != former
    assert not former.exists()


TEXTS = {path: path.read_text(encoding="utf-8") for path in KERNELS.rglob("*.py")}
MARKED = {
    name
    for text in TEXTS.values()
    for name in re.findall(r"^@by_wall.*\ndef (\w+)", text, re.MULTILINE)
}
LAWS = sorted(p for p in TEXTS if p.parent.name == "laws" and p.stem not in ("__init__", "law"))


def idle(text):
    """Return the kernels of a law that neither take the place of another nor are called there."""
    names = re.findall(r"^def (\w+)", text, re.MULTILINE)
    return {name for name in names if len(re.findall(rf"\b{name}\b", text)) == 1} - MARKED


@pytest.mark.parametrize("path", LAWS, ids=lambda path: path.stem)
def test_each_kernel_of_a_law_is_called(path):
    assert idle(TEXTS[path]) == set()
    assert idle(TEXTS[path].replace("def made(", "def mad(")) == {"mad"}


def properties(texts):
    """Return the properties that kernels ask laws for, and those that laws assign."""
    asked = set(re.findall(r'\bsays\([\w.]+, "(\w+)"\)', "\n".join(texts)))
    assigned = {w for p in LAWS for w in re.findall(r"^([A-Z_]+) = True$", TEXTS[p], re.MULTILINE)}
    return asked, assigned


def test_each_property_that_is_asked_for_is_one_of_a_law():
    asked, assigned = properties(TEXTS.values())
    assert len(asked) > 2
    assert asked == assigned
    asked, assigned = properties([*TEXTS.values(), 'if says(near, "AT_LAST"):'])
    assert asked != assigned
