"""Every case whose orbits can be shortened does its work: systems, laws, records and loads."""

import pytest

from benchmarks import cases

LONG = {"diagram", "verdicts", "branch", "host-3-verdicts", "host-3-branch", "host-3-map"}
"""Those of settled orbits."""

LARGER = {"host-5", "host-10", "host-20", "host-10-energies"}
"""Those that differ from others by their size alone."""

COMPILED = {"classify", "blow"}
"""Those that take as long in one call as compiling does."""


@pytest.fixture(autouse=True)
def short(monkeypatch):
    orbits, shaken, often, sampled = cases.orbits, cases.shaken, cases.often, cases.sampled
    monkeypatch.setattr(cases, "orbits", lambda s, n, *how, **more: orbits(s, 1, *how, **more))
    monkeypatch.setattr(cases, "shaken", lambda system, times: shaken(system, 1))
    monkeypatch.setattr(cases, "sampled", lambda count: sampled(1))
    monkeypatch.setattr(
        cases, "often", lambda times, work, *words, **options: often(1, work, *words, **options)
    )
    monkeypatch.setattr(cases, "PERIODS", 1)
    monkeypatch.setattr(cases, "SETTLED_SOONER", 1)
    monkeypatch.setattr(cases, "SAMPLES", 20)


@pytest.mark.parametrize("name", sorted(cases.CASES.keys() - LONG - LARGER - COMPILED))
def test_a_case_does_its_work(name):
    result = cases.CASES[name]()()
    if hasattr(result, "read"):
        with result.read() as archive:
            assert "section" in archive
            assert (archive["status"] == 0).all()
