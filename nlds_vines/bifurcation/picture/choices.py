"""What a picture of a map may show, checked before anything is computed."""

from __future__ import annotations

from collections.abc import Collection

from nlds_vines.errors import RequestError, unknown

REGIMES, COEXISTING, SHARES, SHARE = "regimes", "coexisting", "shares", "share:"

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
"""The recorded numbers that a map can show, the most telling first."""

_OF_SEVERAL = (COEXISTING, SHARES)


def usual_show(names: Collection[str]) -> str | None:
    """Return what a map of these datasets shows unasked: its regimes, or a number; else None."""
    if "label" in names:
        return REGIMES
    return next((name for name in NUMBERS if name in names), None)


def check_show(show: str, axes: int, starts: int, names: Collection[str]) -> None:
    """Raise `RequestError` unless a scan can show it.

    Arguments: `show`, one of regimes, coexisting, shares, share:LABEL and `NUMBERS`; how many
    parameters vary; how many starts a cell has; the `names` of the datasets.
    """
    if axes != 2:
        raise RequestError(f"show = {show!r} is for maps: vary two parameters, or leave it out")
    known = (REGIMES, *_OF_SEVERAL, f"{SHARE}LABEL", *NUMBERS)
    is_share = show.startswith(SHARE) and len(show) > len(SHARE)
    if not is_share and show not in known[:3] + NUMBERS:
        raise unknown("show", show, known)
    if show in NUMBERS:
        if show not in names:
            raise RequestError(f"show = {show!r} is not recorded")
        return
    if "label" not in names:
        raise RequestError(f"show = {show!r} needs regimes: record regime as well")
    if (is_share or show in _OF_SEVERAL) and starts < 2:
        raise RequestError(f"show = {show!r} needs several starts: random:N or both")
