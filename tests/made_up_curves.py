"""Results whose order and cost are chosen."""

from nlds_vines.accuracy.measured_cases import Result, Setting


def result(value, error, seconds, *, method="rk4", ours=True, **more):
    more = {"missed": 0.0, **more}
    setting = Setting(method, value, f"{value:g} steps", ours)
    return Result(setting, error=error, seconds=seconds, **more)


def of_order(p, method="rk4", cost=1e-6):
    """Return results of order p in the steps, at a cost in proportion to them."""
    steps = (16, 32, 64, 128, 256)
    return tuple(result(n, 0.1 * n**-p, cost * n, method=method) for n in steps)
