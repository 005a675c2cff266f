"""What a picture may show; checked before anything is computed, and before an archive is drawn."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from nlds_vines.bifurcation.picture.ordinates import Quantity
from nlds_vines.errors import RequestError, unknown
from nlds_vines.model.quantities import drawn_in, held_in
from nlds_vines.model.quantity import MAPS
from nlds_vines.orbits.records import ATTRACTOR
from nlds_vines.plotting.bands import is_list

REGIMES, COEXISTING, SHARES, SHARE = "regimes", "coexisting", "shares", "share:"
BASINS = "basins"
"""The choices beside numbers; `SHARE` is followed by a label, as in `share:T,0`."""

LOG, LINEAR = WAYS = "log:", "linear:"
"""What may stand before a number of a map, to choose how it becomes shades: `log:E1max`."""

NUMBERS = drawn_in(MAPS)
"""The numbers that a map shows by default, the first that is recorded; any other on request."""

GROUPS: Mapping[str, tuple[str, ...]] = {
    "displacement": ("x2", "x1", "x"),
    "velocity": ("v2", "v1", "v"),
    "energy": tuple(entry.name for entry in held_in("energy")),
}
"""Words for several quantities of a diagram."""

_OF_SEVERAL_STARTS = (COEXISTING, SHARES)


def is_map(values: Sequence[np.ndarray]) -> bool:
    """Return whether the axes of a scan, with these values, are two ranges: else it has curves."""
    return len(values) == 2 and not any(map(is_list, values))


def usual_show(recorded: Mapping[str, Quantity], labeled: bool) -> str | None:
    """Return what a map shows by default: regimes, or else a number; None if there is neither."""
    if labeled:
        return REGIMES
    return next((name for name in NUMBERS if name in recorded), None)


def way_and_number(show: str) -> tuple[str, str]:
    """Return the one of `WAYS` that a number follows, empty for none, and the number's name."""
    scale = next((word for word in WAYS if show.startswith(word)), "")
    return scale, show.removeprefix(scale)


def rows_of(show: str, drawn: Mapping[str, Quantity]) -> list[str]:
    """Return the quantities that a diagram is to show, in order: `x1,energy` has three.

    Raises `RequestError` for one that is not recorded; `regimes` among them is passed over.
    """
    rows: list[str] = []
    for word in filter(None, (piece.strip() for piece in show.split(","))):
        names = [name for name in GROUPS.get(word, ()) if name in drawn] or [word]
        rows += [name for name in names if name != REGIMES]
    numbers = [name for name, quantity in drawn.items() if not quantity.coded]
    for name in rows:
        if name not in numbers:
            raise _not_recorded(name, [REGIMES, *GROUPS, *numbers])
    return list(dict.fromkeys(rows))


def check_show(
    show: str,
    values: Sequence[np.ndarray],
    starts: int,
    drawn: Mapping[str, Quantity],
    labeled: bool,
) -> None:
    """Raise `RequestError` unless the picture of a scan can show `show`.

    Arguments: `show`, as `drawing.draw` takes it; the `values` of each axis; how many starts a cell
    has; the quantities that are recorded, and whether labels are.
    """
    if show == BASINS:
        if ATTRACTOR not in drawn:
            raise RequestError(f"show = {show!r} needs attractors: scan with --record {ATTRACTOR}")
        return
    needs_labels = show in (REGIMES, *_OF_SEVERAL_STARTS) or show.startswith(SHARE)
    if needs_labels and not labeled:
        raise RequestError(f"show = {show!r} needs regimes: scan with regime in --record")
    if not is_map(values):
        if show in _OF_SEVERAL_STARTS or show.startswith(SHARE):
            raise RequestError(f"show = {show!r} is for maps: vary two parameters over ranges")
        rows_of(show, drawn)
        return
    is_share = show.startswith(SHARE) and len(show) > len(SHARE)
    if (is_share or show in _OF_SEVERAL_STARTS) and starts < 2:
        raise RequestError(f"show = {show!r} needs several starts: random:N or both")
    scale, name = way_and_number(show)
    numbers = [n for n, one in drawn.items() if one.single or (one.coded and not scale)]
    if not (is_share or show in (REGIMES, *_OF_SEVERAL_STARTS) or name in numbers):
        others = [] if scale else [REGIMES, *_OF_SEVERAL_STARTS, f"{SHARE}LABEL"]
        raise _not_recorded(name, [*others, *numbers])


def _not_recorded(show: str, allowed: Sequence[str]) -> RequestError:
    """Return the error of something that exists and is not recorded, or that does not exist."""
    if show in NUMBERS or any(show in names for names in GROUPS.values()):
        return RequestError(f"show = {show!r} is not recorded; there are: {', '.join(allowed)}")
    return unknown("show", show, allowed)
