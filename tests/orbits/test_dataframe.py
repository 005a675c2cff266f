"""An orbit as a table of pandas: its columns, their units and what they mean."""

import numpy as np
import pytest

import nlds_vines as nv
from nlds_vines.orbits.simulation import Orbit

pandas = pytest.importorskip("pandas", reason="pandas is not installed")


def made_up(name, states):
    """Return an orbit with this trajectory, 64 states a period."""
    system = nv.load_system(name)
    period = 2.0 * np.pi / system.parameters["omega"]
    time = np.arange(1, len(states) + 1) * period / 64
    return Orbit(system, states[-1], trajectory=np.array(states), time=time)


def test_a_trajectory_becomes_a_table():
    p = nv.load_system("ssul-set6").parameters
    states = [[0.01 * i, 0.1, 0.0, -0.2] for i in range(-64, 64)]
    frame = made_up("ssul-set6", states).to_dataframe()
    assert list(frame) == ["time", "x1", "v1", "x2", "v2", "phase", "force", "contact"]
    assert (frame[["x1", "v1", "x2", "v2"]].to_numpy() == states).all()
    assert np.allclose(frame.force, p["P"] * np.cos(p["omega"] * frame.time), atol=1e-9 * p["P"])
    assert np.allclose(frame.force, p["P"] * np.cos(frame.phase), atol=1e-9 * p["P"])
    assert (frame.phase >= 0.0).all()
    assert (frame.phase < 2.0 * np.pi).all()
    assert 0 < (frame.contact > 0.0).sum() < len(frame)
    assert set(frame.attrs["units"]) == set(frame)
    assert frame.attrs["units"]["contact"] == "N"


def test_two_walls_have_two_columns():
    states = [[0.05 * i, 0.0, 0.0, 0.0] for i in range(-64, 64)]
    frame = made_up("ssbl", states).to_dataframe()
    assert frame.contact_near.max() > 0.0
    assert frame.contact_far.min() < 0.0
    assert frame.contact_near.min() == frame.contact_far.max() == 0.0


def test_rigid_walls_have_none():
    frame = made_up("impact-oscillator", [[0.0, 1.0], [0.1, 0.5]]).to_dataframe()
    assert list(frame)[1:] == [
        *nv.load_system("impact-oscillator").scene.components,
        "phase",
        "force",
    ]


def test_without_a_trajectory_it_is_refused():
    orbit = nv.simulate("ssul-set6", 2)
    with pytest.raises(nv.RequestError, match="no trajectory"):
        orbit.to_dataframe()
