"""Made-up results, archives and parts of them: what the tests of archives share."""

import h5py
import numpy as np

from nlds_vines.archives import archive
from nlds_vines.engine.records import WANTS, plain
from nlds_vines.scans.block import Block
from scans import scan_of, written

PLAIN = plain(WANTS)

PASSING = {"history", "argv", "seconds", "threads", "commit", "replayed"}
"""Attributes that tell of the run and not of the request."""


def make_scan(want=PLAIN, vary=None, start="rest", system="ssul-set6", **settings):
    vary = vary or {"omega": {"start": 5.0, "stop": 8.0, "num": 13}}
    return scan_of(system, want, vary, start, changes=settings, transient=1, periods=3)


MAP = {
    "omega": {"start": 5.0, "stop": 8.0, "num": 13},
    "P": {"start": 600.0, "stop": 1000.0, "num": 6},
}


def cut(scan, length=5):
    whole = tuple((0, size) for size in scan.shape[1:])
    firsts = range(0, scan.shape[0], length)
    return [
        Block(i, ((first, min(first + length, scan.shape[0])), *whole))
        for i, first in enumerate(firsts)
    ]


def results(scan, block):
    """Return made-up results: a function of the cell alone, whatever block it is in."""
    arrays = {}
    for entry in scan.table.datasets.values():
        shape = scan.table.shape(entry.name)
        rng = np.random.default_rng(len(entry.name))
        if entry.dtype == "str":
            whole = rng.choice(np.array(["T,1", "3T,3", "chaos", "πéà"], dtype=object), shape)
        elif entry.dtype == "float64":
            whole = rng.normal(size=shape)
            whole.flat[:3] = np.inf, np.nan, -0.0
        else:
            whole = rng.choice(list((entry.flags or dict(enumerate(range(5)))).values()), shape)
        arrays[entry.name] = whole[block.selection]
    return arrays


def write(path, scan, blocks=None, **how):
    blocks = cut(scan) if blocks is None else blocks
    return written(path, scan, blocks, lambda block: results(scan, block), **how)


def arrays(path):
    with archive.read(path) as view:
        return {name: view[name] for name in view.names}


def content(path):
    """Return all that a request determines, bit by bit: datasets, scales, lasting attributes."""
    with h5py.File(path) as file:
        bits = {name: (values.shape, values[()].tobytes()) for name, values in file.items()}
        return bits | {"attributes": {k: v for k, v in file.attrs.items() if k not in PASSING}}
