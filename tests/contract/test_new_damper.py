"""A new damper is one entry of the scenes and one of the catalog: done here with an example.

A damper in a symmetric cage: equation (5) with two obstacles at the same distance D on either side.
The test adds the entries, touches no kernel, and asks for facts that need no simulation.
"""

import numpy as np
import pytest
from support import BOTH, shortening, steady_state

from nlds_vines.archives.archive import read
from nlds_vines.engine.simulation import simulate
from nlds_vines.model import catalog as catalog_module
from nlds_vines.model.catalog import catalog, load_system
from nlds_vines.model.parameters import DAMPER, FORCING, STRUCTURE
from nlds_vines.model.scenes import SCENES, Scene

CAGED = Scene(
    kind="caged",
    meaning="damper in a cage: two obstacles at the same distance",
    parameter_names=(*STRUCTURE, *DAMPER, "D", *FORCING),
    rest=lambda p: 0.0 * p["D"],
    gap_near=lambda p: p["D"],
    gap_far=lambda p: p["D"],
    obstacle=lambda p: {"left stop": -p["D"], "right stop": p["D"]},
    struck={"near": "left stop", "far": "right stop"},
)

ENTRY = """
[systems.caged-one]
title = "A damper in a cage"
kind = "caged"
groups = ["structure", "damper-mass", "force", "tuning-frequency", "materials", "surfaces"]
source = "made up"
values = { k2 = 600.0, c2 = 262.0, D = 0.5 }
"""


@pytest.fixture
def caged(here, monkeypatch):
    """Add the scene and the system; work in an empty folder."""
    monkeypatch.setitem(SCENES, "caged", CAGED)
    original = catalog_module.resource_text
    added = {"dampers.toml": ENTRY}
    monkeypatch.setattr(
        catalog_module, "resource_text", lambda name: original(name) + added.get(name, "")
    )
    read_once = (catalog, catalog_module._document, catalog_module.system_named)
    for what in read_once:
        what.cache_clear()
    yield here
    for what in read_once:
        what.cache_clear()


@pytest.mark.kernels
def test_the_command_knows_it(caged, ask, refusal):
    """Its cage is out of reach at D = 0.5 m: the steady state is that of the tuned mass damper."""
    scan = ["--system", "caged-one", "--vary", "omega=6.0:6.5:3", "--transient", "300"]
    want = ["--periods", "20", "--record", "section,impacts,regime"]
    ask("bifurcation", *scan, *want, "-o", "caged.h5", "--plot", "caged.png", "--quiet")
    assert (caged / "caged.png").stat().st_size > 0
    with read("caged.h5") as archive:
        for i, omega in enumerate((6.0, 6.25, 6.5)):
            p = load_system("caged-one", omega=omega).parameters
            assert shortening(p) < p["D"]
            expected = np.tile(steady_state(p), (20, 1))
            np.testing.assert_allclose(archive["section"][i, 0], expected, rtol=0, atol=1e-10)
        assert archive["label"][:, 0].tolist() == ["T,0"] * 3
        assert list(archive["wall"]) == ["left stop", "right stop"]
    line = refusal("bifurcation", "--system", "caged-one", "--set", "C=1")
    assert "kind 'caged' has no parameter 'C'" in line


@pytest.mark.kernels
def test_its_cage_is_symmetric(caged):
    """Without a force equation (5) is odd, and so is every bit of the orbit."""
    system = load_system("caged-one", D=0.02, P=0.0, c1=0.0, c2=0.0)
    start = np.array([0.01, 0.9, -0.005, 1.4])
    one, other = (simulate(system, 30, start=sign * start, record=BOTH) for sign in (1, -1))
    np.testing.assert_array_equal(one.section, -other.section)
    assert set(one.impacts["wall"]) == {"left stop", "right stop"}
    opposite = {"left stop": "right stop", "right stop": "left stop"}
    assert [opposite[wall] for wall in one.impacts["wall"]] == other.impacts["wall"].tolist()
    np.testing.assert_array_equal(one.impacts["depth"], other.impacts["depth"])


def test_a_scene_that_would_go_wrong_silently_is_refused():
    with pytest.raises(ValueError, match="no wall: nothing checks"):
        Scene("bad", "a limit alone", (), rest=lambda p: 0.0, limit=lambda p: 1.0)
    with pytest.raises(ValueError, match="16 letters"):
        Scene("bad", "a long name", (), struck={"near": "an obstacle of many words"})
