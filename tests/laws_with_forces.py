"""Contact laws that tests compare, each with its force as a plain function."""

from collections.abc import Callable
from dataclasses import dataclass

STEEP = 3e7  # K of the powers


@dataclass(frozen=True)
class Law:
    """Constants of a law, and its force [N] at a depth z [m] that grows with s [m/s]."""

    given: dict
    force: Callable[[float, float], float]


def power(n, K=STEEP, a=0.0):
    def force(z, s):
        return K * max(z, 0.0) ** n * max(0.0, 1.0 + a * s)

    return force


LAWS = {
    "linear": Law({"law": "linear", "kc": 3e6}, lambda z, s: 3e6 * z),
    "damped": Law(
        {"law": "linear", "kc": 3e6, "cc": 2000.0}, lambda z, s: max(0.0, 3e6 * z + 2000.0 * s)
    ),
    "pulling": Law(
        {"law": "kelvin-voigt", "kc": 3e6, "cc": 2000.0}, lambda z, s: 3e6 * z + 2000.0 * s
    ),
    "n = 1": Law({"law": "power", "K": 3e6, "exponent": 1.0}, power(1.0, 3e6)),
    "n = 1.2": Law({"law": "power", "K": 6e6, "exponent": 1.2}, power(1.2, 6e6)),
    "n = 1.37": Law({"law": "power", "K": 1e7, "exponent": 1.37}, power(1.37, 1e7)),
    "n = 2": Law({"law": "power", "K": 5e8, "exponent": 2.0}, power(2.0, 5e8)),
    "n = 3": Law({"law": "power", "K": 2e11, "exponent": 3.0}, power(3.0, 2e11)),
    "hunt-crossley": Law({"K": STEEP, "hunt_crossley": 0.2}, power(1.5, STEEP, 0.2)),
    "damped power": Law(
        {"law": "power", "K": 5e8, "exponent": 2.0, "hunt_crossley": 0.1}, power(2.0, 5e8, 0.1)
    ),
}
