"""Verdicts: what each label needs, on sequences made up and on orbits whose nature is known."""

from types import SimpleNamespace

import numpy as np
import pytest
from plain_orbit import logistic, noise, torus

from nlds_vines import classify, load_system
from nlds_vines.kernels.cells import verdict
from nlds_vines.kernels.scene import codes

pytestmark = pytest.mark.kernels

EXACT_SUM = -1.3499966666666667  # of the exponents of Set 6 [1/s]: -(c1 + c2)/m1 - c2/m2


SCENE = SimpleNamespace(size=4, trace=-1.35)
"""What the averages and the exponent need to know of a flow."""


def decided(values, largest, width):
    """Return the label of a section from its values and its exponent."""
    record = np.stack([values, values, values, values], axis=-1)
    evidence = np.zeros(codes.LENGTH_OF_ROW)
    evidence[codes.LYAPUNOV], evidence[codes.INTERVAL] = largest, width
    verdict.note_digits(SCENE, record, len(record), len(record), evidence)
    if verdict.seems_chaotic(evidence):
        return codes.CHAOTIC
    if verdict.seems_quasiperiodic(SCENE.trace, evidence):
        return codes.QUASIPERIODIC
    return codes.UNDETERMINED


@pytest.mark.plain
def test_what_each_label_needs_of_sequences_made_up():
    # chaos needs an interval above zero
    chaos, _ = logistic(4.0, 2400)
    assert decided(chaos, 0.69, 0.02) == codes.CHAOTIC
    assert decided(chaos, 0.01, 0.02) == codes.UNDETERMINED
    assert decided(chaos, -0.3, 0.02) == codes.UNDETERMINED
    # a torus needs an exponent of zero and smooth averages
    assert decided(torus(2400), 0.0, 1e-3) == codes.QUASIPERIODIC
    assert decided(torus(2400), -0.2, 1e-3) == codes.UNDETERMINED
    assert decided(logistic(4.0, 2400)[0], 0.0, 1e-3) == codes.UNDETERMINED
    # smooth averages are no chaos
    assert decided(torus(2400), 0.1, 0.02) == codes.UNDETERMINED
    # noise is nothing
    assert decided(noise(2400), 0.0, 1e-3) == codes.UNDETERMINED
    assert decided(torus(2400) + 1e-2 * noise(2400), 0.0, 1e-3) == codes.UNDETERMINED
    # averages of the worst component decide
    smooth, rough = torus(2400), logistic(4.0, 2400)[0]
    for columns in ((smooth, rough), (rough, smooth)):
        x1, x2 = columns
        record, evidence = np.stack([x1, x1, x2, x2], axis=-1), np.zeros(codes.LENGTH_OF_ROW)
        verdict.note_digits(SCENE, record, 2400, 2400, evidence)
        assert evidence[codes.DIGITS] < 4.0


@pytest.mark.plain
@pytest.mark.parametrize(
    ("decay", "steady"), [(0, True), (1e-3, True), (0.5, False), (4, False), (40, False)]
)
def test_a_motion_that_shrinks_is_not_steady(decay, steady):
    """The amplitude decays by exp(-decay) over the sections; the mean is far from zero."""
    shrinking = 100.0 + torus(600) * np.exp(-decay * np.linspace(0, 1, 600))
    even = 100.0 + torus(600)
    for column in (0, 2):  # the displacements
        record = np.stack([even, shrinking, even, shrinking], axis=-1)
        record[:, column] = shrinking
        assert verdict.is_steady(SCENE, record, 600, 600) == steady


@pytest.mark.parametrize(
    ("omega", "label"),
    [(5.0, "T,1"), (5.7, "T,1"), (6.28, "T,1"), (7.35, "T,1"), (7.364, "2T,2"), (7.45, "3T,2"),
     (7.5, "3T,2"), (7.7, "4T,2"), (7.8, "2T,1"), (7.9, "2T,1"), (7.95, "T,0")],
)  # fmt: skip
def test_the_regimes_of_set_6(omega, label):
    regime = classify(load_system("ssul-set6", omega=omega))
    assert regime.label == label
    assert regime.residual < 1e-12
    assert abs(regime.multipliers[0]) < 1.0
    assert regime.exponents.sum() == pytest.approx(EXACT_SUM, abs=1e-8)
    product = np.exp(EXACT_SUM * regime.period * regime.system.period)
    assert regime.multipliers.prod().real == pytest.approx(product, rel=1e-7)
    assert regime.lyapunov == pytest.approx(regime.exponents[0], rel=1e-12)
    assert regime.lyapunov < 0.0
    again = classify(regime.system, start=regime.point, transient=0)
    assert (again.label, again.settling) == (label, 0)


def test_the_published_triple_holds_where_the_contact_is_a_little_softer():
    soft = {"K": 2.5e7}
    three = classify(load_system("ssul-set6", omega=7.375, **soft))
    chaos = classify(load_system("ssul-set6", omega=7.4, **soft))
    # beside the published 7.575 rad/s, where chaos lasts so long that the last bit decides how long
    passing = classify(load_system("ssul-set6", omega=7.572, **soft))
    assert three.label == "3T,3"
    assert chaos.label == "chaos"
    assert 0.0 < chaos.lyapunov - chaos.lyapunov_width < chaos.lyapunov < 0.06
    assert chaos.exponents.sum() == pytest.approx(EXACT_SUM, abs=1e-8)
    assert passing.label == "transient chaos to T,0"
    assert passing.settling > 50
    assert passing.transient_lyapunov - passing.transient_lyapunov_width > 0.0
    assert passing.lyapunov == pytest.approx(-0.27, abs=0.005)


def test_regimes_coexist_where_an_orbit_without_impacts_can_exist():
    below, above = (load_system("ssul-set6", omega=w) for w in (7.4595, 7.4597))
    start = classify(load_system("ssul-set6", omega=7.95)).point
    assert classify(above, start=start).impacts in (0, 2)  # it coexists with 3T,2
    assert classify(below, start=start).impacts > 0
    # regimes coexist above 7.55
    system = load_system("ssul-set6", omega=7.85)
    still = classify(load_system("ssul-set6", omega=7.95)).point
    assert {classify(system).label, classify(system, start=still).label} == {"2T,1", "T,0"}


@pytest.mark.parametrize(
    ("name", "changes", "label"),
    [
        ("ssul-set6", {"omega": 6.28, "c1": 20.0, "c2": 5.0}, "T,1"),
        ("ssbl", {"omega": 6.01, "c2": 20.0}, "transient chaos to T,3"),
    ],
)
def test_a_long_transient_is_chaotic_only_with_an_exponent_above_zero(name, changes, label):
    """Both settle late; along the first the variations do not grow."""
    system = load_system(name, **changes)
    regime = classify(system, transient=500, periods=60, effort="quick")
    assert regime.label == label
    assert regime.settling > 50
    growing = regime.transient_lyapunov - regime.transient_lyapunov_width > 0.0
    assert growing == label.startswith("transient chaos")
