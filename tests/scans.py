"""Scans, their results and their archives, as many tests need them."""

from dataclasses import replace

import numpy as np

from nlds_vines.bifurcation.request import load_scan
from nlds_vines.runs.run_options import RunOptions
from nlds_vines.runs.store import BlockStore
from nlds_vines.scans.block import Block


def scan_of(system, want, vary=None, start="rest", title="a test", changes=None, **sampling):
    """Return a scan from rest over three frequencies, where nothing else is said.

    vary: a table of each axis, or its values; start: a policy, or a table; changes: what is set.
    """
    return load_scan(
        {
            "title": title,
            "system": system,
            "set": changes or {},
            "vary": vary or {"omega": [5.0, 6.0, 7.0]},
            "start": {"policy": start} if isinstance(start, str) else start,
            "sampling": sampling,
            "record": {"want": list(want)},
        }
    )


def whole(scan):
    """Return the block that is all of a scan."""
    return Block(0, tuple((0, size) for size in scan.shape))


def computed(scan):
    """Return the arrays of a scan that is computed in one block."""
    from nlds_vines.bifurcation.run import Computer  # which loads the kernels

    return Computer(scan).block(whole(scan))


def archived(path, scan, arrays):
    """Write an archive of a scan that holds these arrays; return its path."""
    return written(path, scan, [whole(scan)], lambda block: arrays)


def stored(scan, arrays):
    """Return the arrays of a block as its file holds them."""
    kinds = {name: entry.dtype for name, entry in scan.table.datasets.items()}
    return {name: np.asarray(arrays[name], kind) for name, kind in kinds.items()}


def written(path, scan, blocks, results, **how):
    """Do a run of a scan whose blocks have these results; return the path of its archive."""
    from nlds_vines.bifurcation.run import plan_of  # which loads the kernels
    from nlds_vines.scans.run import writer_of

    plan = replace(plan_of(scan), blocks=blocks)
    store = BlockStore(path, scan)

    def work():
        for block in blocks:
            if store.load(block.index, block.expected(scan.table)) is None:
                store.save(block.index, stored(scan, results(block)))
        return writer_of(plan, store)

    store.carry_out(RunOptions(**how), work)
    return path


def unfilled(scan):
    """Return the arrays of a scan's archive by name, everywhere the fill value."""
    table = scan.table
    return {
        name: np.full(
            table.shape(name), entry.fill, object if entry.dtype == "str" else entry.dtype
        )
        for name, entry in table.datasets.items()
    }
