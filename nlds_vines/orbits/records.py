"""What a scan may ask to be recorded, and which of it a scene can give."""

from __future__ import annotations

from collections.abc import Collection, Sequence

from nlds_vines.errors import RequestError, checked_words
from nlds_vines.model.quantities import QUANTITIES, RECORDS, TOUCHES, held_in
from nlds_vines.model.scenes import Scene

WANTS = RECORDS
"""What `[record] want` may ask for."""

USUAL = ("section", "impacts", "energy", "regime")
"""What a scan records unless it says otherwise.

Whatever else looks for a label asks for the same: kernels are compiled for what is recorded."""

JUDGED = frozenset({"regime", "lyapunov", "settling", "evidence", "attractor"})
"""Of `WANTS`, what rests on a verdict."""

ATTRACTOR = "attractor"
"""Of `WANTS`, what an orbit need not be followed to its end for."""

SPECTRAL = ("spectrum", "lines", "broadband")
"""Of `WANTS`, what rests on states at equal steps: on a run of its own."""

NOTED = 4096
"""Periods of a transient, the last ones, in which a verdict looks for the time of settling."""

_SAMPLED = {word for entry in held_in("section") for word in entry.record}
_SAMPLED |= {"modulation"}
_TOUCHED = {word for entry in held_in("touches") for word in entry.record}


def checked_want(want: object) -> tuple[str, ...]:
    """Return a request for records in the order of `WANTS`.

    Raises `RequestError` unless it is a list of one or more different words of `WANTS`.
    """
    names = checked_words("want", want, WANTS)
    return tuple(word for word in WANTS if word in names)


def possible_want(want: Sequence[str], scene: Scene) -> tuple[str, ...]:
    """Return the records of `want` that a scene has: without walls no impacts and clearances."""
    missing = {*RECORDS}.difference(
        *(entry.record[:1] for entry in QUANTITIES if entry.has(scene)),
    )  # and nothing that is recorded of single orbits alone
    return tuple(word for word in want if word not in missing)


def refuse_impossible(want: Sequence[str], scene: Scene) -> None:
    """Raise `RequestError` for the first record of `want` that a scene does not have."""
    for word in want:
        if word not in possible_want(want, scene):
            raise RequestError(
                f"want {word!r} cannot be had: kind {scene.kind!r} ({scene.meaning}) has no "
                f"wall; allowed: {', '.join(possible_want(WANTS, scene))}"
            )


def plain(want: Collection[str]) -> tuple[str, ...]:
    """Return what of a request rests on orbits that are followed to their end, one by one."""
    return tuple(word for word in want if word != ATTRACTOR and word not in SPECTRAL)


def spectral(want: Collection[str]) -> tuple[str, ...]:
    """Return what of a request rests on spectra."""
    return tuple(word for word in want if word in SPECTRAL)


def noted(want: Collection[str], transient: int, periods: int) -> int:
    """Return for how many periods of an orbit its section is kept while it is computed."""
    judged = not JUDGED.isdisjoint(want)
    sampled = periods if judged or not _SAMPLED.isdisjoint(want) else 0
    return sampled + (min(transient, NOTED) if judged else 0)


def touches_noted(want: Collection[str], scene: Scene, periods: int) -> int:
    """Return of how many impacts of an orbit the touch is kept at most."""
    return TOUCHES * periods if scene.walls and not _TOUCHED.isdisjoint(want) else 0
