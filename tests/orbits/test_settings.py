"""How finely a method computes: what may be asked for, and one line where it may not."""

import numpy as np
import pytest

from nlds_vines import load_scan
from nlds_vines.errors import RequestError
from nlds_vines.orbits.solver_settings import (
    FINENESS,
    LEAST_STEPS,
    LEAST_TOLERANCE,
    MOST_TOLERANCE,
    PERIOD_STEPS,
    SHARE,
    TOLERANCE,
    TOLERANCES,
    Settings,
    checked_tolerance,
    chosen_settings,
)


def test_presets_are_numbers_by_another_name():
    assert TOLERANCES == {"draft": 1e-6, "standard": 1e-9, "fine": 1e-12}
    for name, value in TOLERANCES.items():
        assert checked_tolerance(name) == checked_tolerance(value) == value
    assert chosen_settings("exact", {}).tolerance == TOLERANCE == TOLERANCES["standard"]


@pytest.mark.parametrize("value", [1e-13, 1e-3, np.float64(1e-7), 5e-4])
def test_numbers_in_range(value):
    checked = checked_tolerance(value)
    assert type(checked) is float
    assert checked == value
    assert LEAST_TOLERANCE <= checked <= MOST_TOLERANCE


def test_every_method_has_its_own_settings():
    settings = {"tolerance": 1e-6, "nodes": 9, "contact_steps": 20, "period_steps": 64}
    for name in FINENESS:
        method, other = ("rk4", "exact") if name == "period_steps" else ("exact", "rk4")
        assert chosen_settings(method, {name: settings[name]}) != chosen_settings(method, {})
        with pytest.raises(RequestError, match=f"^{name} is of method '{method}'; '{other}' has "):
            chosen_settings(other, {name: settings[name]})
        assert chosen_settings(other, {name: None}) == chosen_settings(other, {})
    assert chosen_settings("rk4", {"period_steps": 64}) == Settings.rk4(64.0)
    assert chosen_settings("rk4", {}) == Settings.rk4(PERIOD_STEPS)


def test_contacts_are_granted_a_share_of_the_tolerance():
    """Several may follow each other in a period."""
    settings = Settings(1e-6)
    assert settings.contact_tolerance == settings.stepped_to == SHARE * 1e-6
    assert Settings(1e-6, contact_steps=28.0).stepped_to == np.inf  # as an expert wants them
    assert {Settings(10.0**-k).steps for k in range(3, 14)} == {LEAST_STEPS}


# ---- tables laid over each other -----------------------------------------------------------------


@pytest.mark.parametrize(
    ("below", "above", "expected"),
    [
        ({"tolerance": 1e-6}, {}, {"tolerance": 1e-6}),
        ({"tolerance": 1e-6}, {"tolerance": 1e-12}, {"tolerance": 1e-12}),
        ({"tolerance": 1e-6, "periods": 3}, {"method": "rk4"}, {"method": "rk4", "periods": 3}),
        ({"tolerance": 1e-6}, {"method": "exact"}, {"method": "exact", "tolerance": 1e-6}),
        ({"method": "rk4", "period_steps": 64}, {"method": "exact"}, {"method": "exact"}),
        ({"nodes": 8, "contact_steps": 20}, {"tolerance": 1e-6}, {"tolerance": 1e-6}),
        ({"nodes": 8}, {"contact_steps": 20}, {"nodes": 8, "contact_steps": 20}),
        ({"nodes": 8}, {"transient": 5}, {"nodes": 8, "transient": 5}),
    ],
)
def test_what_is_asked_last_counts(below, above, expected):
    one = {"system": "tmd", "vary": {"omega": {"values": [6.0]}}}
    scan, other = (
        load_scan(one | {"sampling": low}, {"sampling": high})
        for low, high in ((below, above), (expected, {}))
    )
    assert scan.document()["sampling"] == other.document()["sampling"]
    assert (scan.method, scan.settings) == (other.method, other.settings)
