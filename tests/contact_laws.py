"""Contact laws that tests compare, as the twin of laws is given them."""

from twin_of_laws import Law

STEEP = 3e7  # K of the powers
LAWS = {
    "linear": Law("linear", kc=3e6),
    "damped": Law("linear", kc=3e6, cc=2000.0),
    "pulling": Law("kelvin-voigt", kc=3e6, cc=2000.0),
    "n = 1": Law("power", K=3e6, n=1.0),
    "n = 1.2": Law("power", K=6e6, n=1.2),
    "n = 1.37": Law("power", K=1e7, n=1.37),
    "n = 2": Law("power", K=5e8, n=2.0),
    "n = 3": Law("power", K=2e11, n=3.0),
    "hunt-crossley": Law("hertz", K=STEEP, a=0.2),
    "damped power": Law("power", K=5e8, n=2.0, a=0.1),
}
