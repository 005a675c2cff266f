"""Results and curves whose order and cost are known because they are made up."""

from benchmarks.accuracy.curves import Curve
from nlds_vines.accuracy.measured_cases import Result, Setting


def result(value, error, seconds, *, method="rk4", ours=True, **more):
    more = {"missed": 0.0, **more}
    setting = Setting(method, value, f"{value:g} steps", ours)
    return Result(setting, error=error, seconds=seconds, **more)


def curve(points, method="rk4", doubt=1e-15, **more):
    results = tuple(result(*point, method=method, **more) for point in points)
    return Curve(method, results, doubt)


def of_order(p, method="rk4", cost=1e-6):
    """Return a curve of an exact order in the steps, at a cost in proportion to them."""
    return curve([(n, 0.1 * n**-p, cost * n) for n in (16, 32, 64, 128, 256)], method)
