"""Variations through a short impact: as good as the impact, and linear."""

from typing import NamedTuple

import numpy as np
import pytest
from support import NOTHING, Approach, contact_parts, references, side_of

from nlds_vines.engine.solver_settings import Settings
from nlds_vines.kernels.events.contact import Steps, contact
from nlds_vines.kernels.impact.arc import make_arc
from nlds_vines.kernels.impact.impact import short_impact
from nlds_vines.kernels.impact.inside import Ahead, vary, vary_inside
from nlds_vines.kernels.motion.flight import rate_of
from nlds_vines.kernels.scene.codes import RELEASED, STOPPED

pytestmark = pytest.mark.kernels

SET6 = references()["ssul-set6"].numbers
APPROACH = Approach(speed=1.3, x1=0.011, v1=0.2, phase=1.0)
UNIT = np.eye(4).ravel()


class Impact(NamedTuple):
    """What variations need of an impact: its parts, its touch, and the bound of rates."""

    parts: tuple
    approach: Approach

    @property
    def rate(self):
        return rate_of(*self.parts[:2])

    @property
    def phase(self):
        return self.approach.wave

    def solve(self, arc, impacts=None):
        """Return (solved, s, x1, v1, duration, depth)."""
        return short_impact(side_of(self.parts, arc), impacts, self.phase, self.approach.touch)

    def carried(self, arc, tangent=UNIT, impacts=None):
        """Return the variations (16,) at the release."""
        solved, s, x1, v1, took, _ = self.solve(arc, impacts)
        assert solved
        side, before, variations = side_of(self.parts, arc), self.approach.touch[1:], tangent.copy()
        vary(side, self.phase, before, (s, x1, v1, took), variations)
        return variations

    def stepped(self, steps, time=1.0e3):
        """Return the unit variations at the release, or after a time [s], by steps, and when."""
        matrix, side = UNIT.copy(), side_of(self.parts, steps=Steps(steps, np.inf))
        watch = NOTHING._replace(tangent=matrix)
        event, _, _, _, _, took, _ = contact(side, watch, self.phase, self.approach.touch, time)
        assert event == (RELEASED if time == 1.0e3 else STOPPED)
        return matrix, took

    def ahead(self, arc):
        """Return the impact as it is known at its touch."""
        solved, s, x1, v1, took, _ = self.solve(arc)
        assert solved
        return Ahead(took, 0.0, 0.0, self.approach.touch[1:], (s, x1, v1))

    def side(self, arc):
        """Return a side that steps as finely as its impacts are solved."""
        settled = 1e-12 if arc.settled <= 1e-15 else 1.0
        settings = Settings(tolerance=min(4.0 * arc.tolerance, settled))
        return side_of(self.parts, arc, steps=Steps(settings.steps, settings.stepped_to))

    def cut(self, arc, share):
        """Return the matrices of variations up to a share of the impact, and from there on."""
        ahead = self.ahead(arc)
        ahead = ahead._replace(elapsed=share * ahead.took)
        return ahead, (self.vary(arc, ahead, UNIT, True), self.vary(arc, ahead, UNIT, False))

    def vary(self, arc, ahead, tangent, begins):
        """Return the variations carried up to the section, or from there on."""
        varied = tangent.copy()
        vary_inside(self.side(arc), self.phase, varied, ahead, begins)
        return varied

    def matrix(self, tangent):
        """Return the matrix of variations with displacements in units of velocity by `rate`."""
        scales = np.array([self.rate, 1.0, self.rate, 1.0])
        return tangent.reshape(4, 4).T * scales[:, np.newaxis] / scales

    def error(self, arc, steps=100.0):
        """Return the largest error of the matrix, relative to its largest entry."""
        exact = self.matrix(self.stepped(steps)[0])
        return np.abs(self.matrix(self.carried(arc)) - exact).max() / np.abs(exact).max()


def impact_with(**changes):
    return Impact(contact_parts(**{**SET6, "near": SET6["C"], **changes}), APPROACH)


def random_impacts(count, arc, seed=5):
    """Return impacts with everything varied, dashpots above all, that are short."""
    rng, impacts = np.random.default_rng(seed), []
    while len(impacts) < count:
        names = ("m1", "k1", "c1", "m2", "k2", "P")
        changes = {name: SET6[name] * 10 ** rng.uniform(-1, 1) for name in names}
        changes["c2"] = SET6["c2"] * 10 ** rng.uniform(-1, 2)
        changes["K"] = 10 ** rng.uniform(5, 12)
        speed, phase = 10 ** rng.uniform(-2, 1), rng.uniform(0, 6)
        approach = Approach(speed, *rng.normal(0, (0.05, 0.3)), phase)
        impact = impact_with(**changes)._replace(approach=approach)
        if impact.solve(arc)[0]:
            impacts.append(impact)
    return impacts


@pytest.mark.parametrize("tolerance", [1e-6, 1e-9, 1e-12])
def test_variations_err_by_the_tolerance(tolerance):
    """Against a hundred steps; at most a few times, as errors of an impact's ends do."""
    arc = make_arc(tolerance)
    errors = [impact.error(arc) for impact in random_impacts(80, arc)]
    assert max(errors) <= 5 * tolerance
    assert np.median(errors) <= 0.2 * tolerance


SHARES = (1e-3, 0.1, 0.4, 0.499, 0.501, 0.7, 0.9, 0.999)


@pytest.mark.parametrize("tolerance", [1e-6, 1e-9, 1e-12])
def test_a_section_may_cut_an_impact_anywhere(tolerance):
    """Notices: a half taken for the other, time that runs on backward, the wall's own force."""
    arc, errors = make_arc(tolerance), []
    for impact, share in zip(random_impacts(80, arc, seed=8), 10 * SHARES, strict=True):
        ahead, (first, second) = impact.cut(arc, share)
        exact = impact.matrix(impact.stepped(100.0, ahead.elapsed)[0])
        errors.append(np.abs(impact.matrix(first) - exact).max() / np.abs(exact).max())
        whole = impact.matrix(impact.carried(arc))
        both = impact.matrix((first.reshape(4, 4) @ second.reshape(4, 4)).ravel())
        assert np.abs(both - whole).max() <= 1e-12 * np.abs(whole).max()
    assert max(errors) <= tolerance
    assert np.median(errors) <= 0.1 * tolerance


@pytest.mark.parametrize("share", [0.2, 0.8])
def test_variations_go_on_behind_a_section(share):
    """With what was kept, or, where nothing was, the same again."""
    arc, impact, tangent = make_arc(), impact_with(), np.random.default_rng(4).normal(size=16)
    ahead, (first, _) = impact.cut(arc, share)
    carried = impact.vary(arc, ahead, tangent, True)
    np.testing.assert_allclose(
        carried.reshape(4, 4), tangent.reshape(4, 4) @ first.reshape(4, 4), rtol=1e-12
    )
    again = impact.vary(make_arc(), ahead, carried, False)
    carried = impact.vary(arc, ahead, carried, False)
    np.testing.assert_array_equal(carried, again)
    expected = tangent.reshape(4, 4) @ impact.carried(arc).reshape(4, 4)
    np.testing.assert_allclose(carried.reshape(4, 4), expected, rtol=1e-9)


def test_variations_are_linear_and_any_may_be_zero_or_no_number():
    """A sum goes where the sum of both goes, to the tolerance; sizes do not matter."""
    arc, impact, rng = make_arc(), impact_with(), np.random.default_rng(2)
    matrix = impact.carried(arc).reshape(4, 4)
    for size in (1e-12, 1.0, 1e12):
        tangent = size * rng.normal(size=(4, 4))
        carried = impact.carried(arc, tangent.ravel()).reshape(4, 4)
        np.testing.assert_allclose(carried, tangent @ matrix, rtol=0, atol=1e-8 * size)
    # as those of a scene of fewer numbers are; the others do not notice
    tangent = UNIT.copy()
    tangent[4:] = 0.0
    carried = impact.carried(arc, tangent)
    assert (carried[4:] == 0.0).all()
    np.testing.assert_allclose(carried[:4], impact.carried(arc)[:4], rtol=0, atol=1e-9)
    # one that is no number stays none
    tangent = UNIT.copy()
    tangent[5] = np.nan
    carried = impact.carried(arc, tangent)
    assert np.isnan(carried[4:8]).any()
    assert np.isfinite(carried[:4]).all()


@pytest.mark.parametrize("nodes", [6, 7, 9])
def test_numbers_of_nodes_that_are_no_fours(nodes):
    arc, few = make_arc(nodes=nodes), make_arc(nodes=nodes - 3)
    assert impact_with().error(arc) <= 0.1 * impact_with().error(few)


@pytest.mark.parametrize("nodes", [14, 18])
def test_variations_settle_at_the_last_node_where_fours_are_padded(nodes):
    impacts = random_impacts(40, make_arc(1e-12, nodes=24))
    assert max(impact.error(make_arc(1e-12, nodes=nodes)) for impact in impacts) <= 1e-9
