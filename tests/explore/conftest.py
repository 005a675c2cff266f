"""Archives of small scans, computed once for all tests of the pages."""

import numpy as np
import pytest
from planes import PLANE

import nlds_vines as nv
from nlds_vines.bifurcation.request import load_scan
from nlds_vines.engine.records import OK
from nlds_vines.explore.map_data import Stored
from scans import archived, unfilled

MAP = {
    "title": "a small map",
    "system": "ssul-set6",
    "vary": {
        "omega": {"start": 7.3, "stop": 7.7, "num": 6},
        "P": {"start": 700.0, "stop": 900.0, "num": 4},
    },
    "start": {"policy": "random", "count": 2, "seed": 3},
    "sampling": {"transient": 60, "periods": 30, "effort": "quick"},
    "record": {
        "want": ["section", "impacts", "energy", "regime", "lyapunov", "settling", "evidence"]
    },
}
ALONG = {"omega": {"start": 7.3, "stop": 7.7, "num": 9}}
DIAGRAM = {**MAP, "vary": ALONG, "start": {"policy": "rest"}}
SWEEPS = {**MAP, "vary": ALONG, "start": {"policy": "both"}}
BASIN = {
    **PLANE,
    "vary": {
        "x_0": {"start": -2.0, "stop": 1.25, "num": 14},  # the last one is beyond the stop
        "v_0": {"start": -3.0, "stop": 3.0, "num": 13},
    },
}


def host_system():
    """Return a host of two masses, on the second of which two dampers hang."""
    walls = [nv.Wall(0.02, side, law="restitution", e=0.6) for side in "+-"]
    joint = {"attached_to": "x2", "m": 0.05, "k": 0.05, "c": 0.01, "walls": walls}
    dampers = [nv.Damper(name, **joint) for name in "ab"]
    host = nv.chain([1.0, 1.0], [4.0, 4.0], grounds=[4.0, 0.0], ratio=0.02)
    return nv.System.from_host(host, dampers, force={"x2": 1.5}, omega=1.95)


HOST_MAP = {
    "title": "a small map of a host",
    "system": host_system(),
    "vary": {"omega": [1.85, 1.95, 2.05], "a.gap": [0.01, 0.03]},
    "start": {"policy": "random", "count": 2, "seed": 3},
    "sampling": {"transient": 40, "periods": 20, "effort": "quick"},
    "record": {
        "want": ["section", "impacts", "energy", "response", "regime", "lyapunov"],
        "of": ["x2", "x2-x1"],
    },
}


def made_up(document, path):
    """Write an archive of a scan without computing it: nothing in it is known."""
    scan = load_scan(document)
    arrays = unfilled(scan)
    arrays["label"][...] = "undetermined"
    arrays["status"][...] = OK
    return archived(path, scan, arrays)


def filled(document):
    """Return a scan with made-up labels and numbers in all that it records; nothing is computed."""
    scan = load_scan(document)
    generator, arrays = np.random.default_rng(0), unfilled(scan)
    for name, array in arrays.items():
        if name == "label":
            words = np.array(["T,1", "T,0", "3T,2", "chaos"], dtype=object)
            array[...] = words[generator.integers(0, 4, array.shape)]
        elif array.dtype.kind == "f":
            array[...] = generator.lognormal(size=array.shape)
        elif array.dtype.kind in "iu":
            array[...] = generator.integers(1, 4, array.shape)
    arrays["status"][...] = OK
    return Stored(scan, arrays)


@pytest.fixture(scope="session")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("explore")


@pytest.fixture(scope="session")
def small_map(folder):
    return nv.scan(MAP, to=folder / "map.h5")


@pytest.fixture(scope="session")
def small_diagram(folder):
    return nv.scan(DIAGRAM, to=folder / "diagram.h5")


@pytest.fixture(scope="session")
def small_basin(folder):
    return nv.scan(BASIN, to=folder / "basin.h5")


@pytest.fixture(scope="session")
def small_sweeps(folder):
    return nv.scan(SWEEPS, to=folder / "sweeps.h5")
