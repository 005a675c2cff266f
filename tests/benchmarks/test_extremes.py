"""The ten extremes stay within their bounds, and a fault in what they compare exceeds them."""

import math

import pytest

from benchmarks import extremes
from benchmarks.extremes import EXTREMES

pytestmark = pytest.mark.kernels


@pytest.mark.parametrize("extreme", EXTREMES, ids=lambda extreme: extreme.name)
def test_an_extreme_stays_within_its_bound(extreme):
    assert extreme.measure() <= extreme.bound


load_system, real_system = extremes.load_system, extremes.System
linear, split, steady = extremes.linear_sections, extremes.scipy_orbit, extremes.steady_state
FAULTS = {
    "stiff": ("DURATION", extremes.DURATION * (1 + 1e-9)),
    "soft": ("linear_sections", lambda *how: linear(*how) * (1 + 1e-9)),
    "grazing": ("steady_state", lambda system: extremes.rest_state(system)),
    "undamped": ("energy_of", lambda system, states: states[:, 1] ** 2),
    "mass ratio": ("scipy_orbit", lambda system, *how: split(system.with_(c1=451.0), *how)),
    "slow": ("steady_state", lambda system: extremes.rest_state(system)),
    "fast": ("steady_state", lambda system: steady(system) * (1 + 1e-5)),
    "e = 0 and 1": ("System", lambda kind, p, law: real_system(kind, {**p, "e": 0.5}, law=law)),
    "overflow": ("is_refused", lambda *how, **options: False),
    "tiny states": ("load_system", lambda name, P: load_system(name, P=max(P, 1e-60))),
}


@pytest.mark.parametrize("extreme", EXTREMES, ids=lambda extreme: extreme.name)
def test_a_fault_exceeds_the_bound(extreme, monkeypatch):
    monkeypatch.setattr(extremes, *FAULTS[extreme.name])
    assert not extreme.measure() <= extreme.bound


def test_a_bound_that_is_exceeded_is_named(monkeypatch, tmp_path, capsys):
    page = tmp_path / "page.md"
    page.write_text("above\n<!-- python -m benchmarks.extremes -->\nold\n<!-- end -->\nbelow\n")
    monkeypatch.setattr("sys.argv", ["extremes", "--page", str(page)])
    for value, status in ((0.5, 0), (math.nan, 1)):
        extreme = extremes.Extreme("number", lambda value=value: value, 1.0)
        monkeypatch.setattr(extremes, "EXTREMES", (extreme,))
        assert extremes.main() == status
        printed = capsys.readouterr().out
        assert ("| broken |" in printed) == bool(status)
        assert page.read_text().startswith("above\n")
        assert printed in page.read_text()
        assert "old" not in page.read_text()
        assert page.read_text().endswith("<!-- end -->\nbelow\n")
