"""Energy maxima where the search for them has nothing to find."""

import time

import numpy as np
import pytest

import nlds_vines as nv
from nlds_vines.kernels.watch.response import proves_no_root


@pytest.mark.kernels
def test_a_double_root_is_not_proven_absent():
    """f(x) = 4 (x - 1/2)^2 - e has f'' = 8: its ends are 1 - e, and its least value is -e."""
    for e in (0.5, 1e-3, -1e-3):
        assert not proves_no_root(1.0 - e, 1.0 - e, 8.0) or e < 0.0
    assert proves_no_root(1.0, 1.0, 7.9)
    assert proves_no_root(0.1, 9.0, 8.0)  # it changes by more than its bend: it is monotone
    assert not proves_no_root(0.1, 9.0, 9.0)
    assert not proves_no_root(-1.0, 1.0, 0.0)
    assert not proves_no_root(0.0, 1.0, 0.0)


def test_a_damper_without_spring_and_dashpot_is_searched_no_longer_than_another(tmp_path):
    """The factor k2 (x2 - rest) + ... of dE2/dt is then zero throughout, and so has no root."""

    def seconds(name, **settings):
        scan = {
            "system": "ssul-set6",
            "set": settings,
            "vary": {"omega": {"values": [6.0, 6.28]}},
            "sampling": {"transient": 0, "periods": 200},
            "record": {"want": ["section", "impacts", "energy", "regime"]},
        }
        began = time.process_time()
        path = nv.scan(scan, to=tmp_path / name)
        with nv.read(path) as archive:
            assert np.isfinite(archive["E2max"]).all()
        return time.process_time() - began

    usual = [seconds(f"{i}.h5", k2=668.9) for i in range(2)][-1]  # the first may have to compile
    assert seconds("free.h5", k2=0.0, c2=0.0) < 10 * usual + 1.0
