"""Archives of small scans, computed once for all tests of the pages."""

import pytest

import nlds_vines as nv

WANT = ["section", "impacts", "energy", "regime", "lyapunov", "settling", "evidence"]


def document(vary, start, **more):
    return {
        "title": "a small map",
        "system": "ssul-set6",
        "vary": vary,
        "start": start,
        "sampling": {"transient": 60, "periods": 30, "effort": "quick"},
        "record": {"want": WANT},
        **more,
    }


MAP = document(
    {
        "omega": {"start": 7.3, "stop": 7.7, "num": 6},
        "P": {"start": 700.0, "stop": 900.0, "num": 4},
    },
    {"policy": "random", "count": 2, "seed": 3},
)
DIAGRAM = document({"omega": {"start": 7.3, "stop": 7.7, "num": 9}}, {"policy": "rest"})
SWEEPS = document({"omega": {"start": 7.3, "stop": 7.7, "num": 9}}, {"policy": "both"})


@pytest.fixture(scope="session")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("explore")


@pytest.fixture(scope="session")
def small_map(folder):
    return nv.bifurcation(MAP, folder / "map.h5")


@pytest.fixture(scope="session")
def small_diagram(folder):
    return nv.bifurcation(DIAGRAM, folder / "diagram.h5")


@pytest.fixture(scope="session")
def small_sweeps(folder):
    return nv.bifurcation(SWEEPS, folder / "sweeps.h5")
