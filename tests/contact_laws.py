"""Contact laws that tests compare: how a system is given each, and how the twin of laws is."""

from typing import NamedTuple

from twin_of_laws import Law

STEEP = 3e7  # K of the powers


class Comparison(NamedTuple):
    """Constants of a law, for `load_system`, and for the twin."""

    constants: dict
    twin: Law


def linear(name="linear", cc=0.0):
    return Comparison({"law": name, "kc": 3e6, "cc": cc}, Law(name, kc=3e6, cc=cc))


def power(n, K, a=0.0):
    constants = {"law": "power", "K": K, "exponent": n} | ({"hunt_crossley": a} if a else {})
    return Comparison(constants, Law("power", K=K, n=n, a=a))


LAWS = {
    "linear": linear(),
    "damped": linear(cc=2000.0),
    "pulling": linear("kelvin-voigt", 2000.0),
    "n = 1": power(1.0, 3e6),
    "n = 1.2": power(1.2, 6e6),
    "n = 1.37": power(1.37, 1e7),
    "n = 2": power(2.0, 5e8),
    "n = 3": power(3.0, 2e11),
    "hunt-crossley": Comparison({"K": STEEP, "hunt_crossley": 0.2}, Law("hertz", K=STEEP, a=0.2)),
    "damped power": power(2.0, 5e8, 0.1),
}
