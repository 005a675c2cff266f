"""The table of what each part costs: every row can be measured, of any system."""

import pytest

from benchmarks import costs
from nlds_vines.model.catalog import load_system
from nlds_vines.model.system import System


@pytest.fixture(autouse=True)
def short(monkeypatch):
    short = {"TRANSIENT": 6, "COUNTED": 10, "ORBITS": 1, "PERIODS": 2, "VARIED": 2, "JUDGED": 1}
    for name, number in {**short, "DIAGRAM": 20}.items():
        monkeypatch.setattr(costs, name, number)


@pytest.mark.parametrize("kind", ["none", "tmd", "ssul", "ssvi-b"])
def test_every_part_can_be_followed(kind):
    names = {"ssul": "ssul-set6", "ssvi-b": "ssbl"}
    system = System(kind, load_system(names.get(kind, kind), omega=6.28).parameters)
    names = []
    for part in costs.parts(system):
        part.run()
        part.without()
        names.append(part.name)
    assert names[1] == "+ four variations"
    assert ("+ impacts" in names) == bool(system.scene.walls)
    assert len(set(names)) == len(names) >= 8


def test_a_row_is_compared_with_the_bare_orbit(monkeypatch):
    times = iter([2e-6, 5e-6, *[1e-6] * 20])
    monkeypatch.setattr(costs, "measured", lambda part: next(times))
    rows = list(costs._rows(load_system("tmd", omega=6.28)))
    assert [row[2:] for row in rows[:3]] == [("2 us", "1"), ("5 us", "2.5"), ("1 us", "0.5")]
