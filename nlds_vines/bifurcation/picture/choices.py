"""What a map may show; checked before anything is computed, and before an archive is drawn."""

from __future__ import annotations

from collections.abc import Collection

from nlds_vines.errors import RequestError, unknown

REGIMES, COEXISTING, SHARES, SHARE = "regimes", "coexisting", "shares", "share:"
"""The choices beside numbers; `SHARE` is followed by a label, as in `share:T,0`."""

NUMBERS = (
    "E1max",
    "E2max",
    "E1peak",
    "E2peak",
    "reduction",
    "impact_rate",
    "clearance",
    "period",
    "settling",
    "lyapunov",
    "transient_lyapunov",
    "violation_depth",
    "error",
    "error_at_end",
    "E1max_error",
)
"""The recorded numbers that a map can show; the first that is recorded is shown by default."""

_OF_SEVERAL_STARTS = (COEXISTING, SHARES)


def usual_show(names: Collection[str]) -> str | None:
    """Return what a map shows by default: regimes, or else a number; None if there is neither.

    Arguments: the `names` of the recorded datasets.
    """
    if "label" in names:
        return REGIMES
    return next((name for name in NUMBERS if name in names), None)


def check_show(show: str, axes: int, starts: int, names: Collection[str]) -> None:
    """Raise `RequestError` unless the picture of a scan can show `show`.

    Arguments: `show`, one of regimes, coexisting, shares, share:LABEL and `NUMBERS`; how many
    parameters vary; how many starts a cell has; the `names` of the recorded datasets.
    """
    if axes != 2:
        raise RequestError(f"show = {show!r} is for maps: vary two parameters, or leave it out")
    is_share = show.startswith(SHARE) and len(show) > len(SHARE)
    if not is_share and show not in (REGIMES, *_OF_SEVERAL_STARTS, *NUMBERS):
        known = (REGIMES, *_OF_SEVERAL_STARTS, f"{SHARE}LABEL", *NUMBERS)
        raise unknown("show", show, known)
    if show in NUMBERS:
        if show not in names:
            raise RequestError(f"show = {show!r} is not recorded")
        return
    if "label" not in names:
        raise RequestError(f"show = {show!r} needs regimes: record regime as well")
    if (is_share or show in _OF_SEVERAL_STARTS) and starts < 2:
        raise RequestError(f"show = {show!r} needs several starts: random:N or both")
