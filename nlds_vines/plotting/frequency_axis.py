"""The frequency of the force on an axis in Hz, or over that of the structure, in place of rad/s.

Pictures are drawn over omega [rad/s].  What changes is what their axes say: places and numbers of
the ticks, and the label.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
from matplotlib.axis import Axis
from matplotlib.figure import Figure
from matplotlib.ticker import AutoLocator, FixedLocator, FuncFormatter, NullLocator

from nlds_vines.archives.archive import ArchiveView
from nlds_vines.errors import RequestError, choice
from nlds_vines.model.ratios import RATIOS
from nlds_vines.plotting.style import axis_label

RAD, HZ, RATIO = "rad/s", "Hz", "ratio"
UNITS = (RAD, HZ, RATIO)
"""In what a frequency axis may count: omega [rad/s], f [Hz], omega over omega0."""

_LABELS = {HZ: r"frequency of the force $f$ [Hz]", RATIO: r"frequency ratio $\omega/\omega_0$"}
_RATIOS = {HZ: "f", RATIO: "omega_ratio"}
_SYMBOLS = {HZ: r"$f$ [Hz]", RATIO: r"$\omega/\omega_0$"}


class _Scaled(AutoLocator):
    """Ticks at round numbers of the values times a factor."""

    def __init__(self, factor: float) -> None:
        super().__init__()
        self._factor = factor

    def tick_values(self, vmin: float, vmax: float) -> Sequence[float]:
        """Return the places of the ticks [rad/s]."""
        places = super().tick_values(vmin * self._factor, vmax * self._factor)
        return [float(place) / self._factor for place in places]


def count_in(figure: Figure, unit: str, view: ArchiveView) -> None:
    """Let the frequency axes of an archive's figure count in a unit of `UNITS`.

    A ratio needs m1 and k1 of the archive, or m and k of an oscillator, the same everywhere in it.

    Raises `RequestError` where there is no such axis, where it is logarithmic, and for a ratio
    without one frequency of the structure.
    """
    if choice("frequency", unit, UNITS) == RAD:
        return
    factor = 1.0 / _unit(view, _RATIOS[unit])
    found = list(_labeled(figure))
    if not found:
        raise RequestError(f"frequency = {unit!r}: the picture has no axis of the frequency omega")
    for axis, along in found:
        if axis.get_scale() != "linear":
            raise RequestError(f"frequency = {unit!r}: the axis of omega is logarithmic")
        short = axis.get_label_text() != axis_label("omega")
        axis.set_label_text((_SYMBOLS if short else _LABELS)[unit])
        ends = axis.get_view_interval()
        for other in along:
            if _has_such_ticks(other, ends):
                other.set_major_locator(_Scaled(factor))
                other.set_major_formatter(FuncFormatter(lambda value, _: f"{value * factor:.6g}"))


def _unit(view: ArchiveView, name: str) -> float:
    """Return the omega [rad/s] at which a ratio is 1 in all of an archive."""
    for ratio in RATIOS:
        values = {need: _only(view, need) for need in ratio.needs}
        if ratio.name == name and all(value > 0.0 for value in values.values()):
            return ratio.unit_of(values)
    raise RequestError(
        "frequency = 'ratio' needs one frequency sqrt(k1 / m1) of the structure, which the archive "
        "does not have: take Hz"
    )


def _only(view: ArchiveView, name: str) -> float:
    """Return the value that a parameter has everywhere in an archive; NaN where it has none."""
    values = view[name] if name in view else np.asarray(view.attrs.get(name, np.nan))
    first = float(np.ravel(values)[0])
    return first if (values == first).all() else np.nan


def _labeled(figure: Figure) -> Iterator[tuple[Axis, Sequence[Axis]]]:
    """Yield axes that are labeled as the frequency omega, and all others along or up the page."""
    whole = axis_label("omega")
    across: list[Axis] = [frame.xaxis for frame in figure.axes]
    up: list[Axis] = [frame.yaxis for frame in figure.axes]
    for along in (across, up):
        for axis in along:
            if axis.get_label_text() in (whole, whole.rpartition("force ")[2]):
                yield axis, along


def _has_such_ticks(other: Axis, ends: tuple[float, float]) -> bool:
    """Tell whether the axis of another panel has the range of a labeled one, and ticks."""
    fixed = isinstance(other.get_major_locator(), FixedLocator | NullLocator)
    return not fixed and np.array_equal(other.get_view_interval(), ends)
