"""Memory does not grow with the forcing periods that are not recorded."""

import json

import pytest
from commands import printed

PROGRAM = """
import json, resource, sys
from pathlib import Path
import numpy as np
import nlds_vines as nv
from nlds_vines.bifurcation import blocks

LANES, LONG = 4, 150_000
blocks.BLOCK_PERIODS = 10**9  # all lanes in one block

def scan(transient):
    "Run a scan and return the greatest memory [MB] that this process has had so far."
    nv.scan({
        "system": "ssul-set6",
        "vary": {"omega": {"start": 6.0, "stop": 7.0, "num": LANES}},
        "sampling": {"transient": transient, "periods": 10},
        "record": {"want": ["section", "impacts", "energy", "regime"]},
    }, to=f"{transient}.h5", overwrite=True)
    return peak()

def peak():
    status = Path("/proc/self/status")  # of this process alone; `getrusage` inherits its parent's
    if status.exists():
        return int(status.read_text().split("VmHWM:")[1].split()[0]) / 2**10
    usage = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return usage / (2**20 if sys.platform == "darwin" else 2**10)

first = scan(100)
again, long = scan(101), scan(LONG)
kept = np.ones((LANES, LONG, 4))
print(json.dumps({"again": again - first, "long": long - again, "kept": peak() - long}))
"""


def growth(folder):
    return json.loads(printed("-c", PROGRAM, cwd=folder, NUMBA_DISABLE_JIT="0"))


@pytest.mark.slow("two processes, and a long transient")
def test_a_thousand_times_the_transient_takes_no_more_memory(tmp_path):
    growth(tmp_path)  # compiles, if need be, which takes more memory than anything here
    megabytes = growth(tmp_path)
    assert megabytes["kept"] > 15.0  # what it would take to keep those states is seen
    assert megabytes["again"] < 4.0
    assert megabytes["long"] < 4.0
