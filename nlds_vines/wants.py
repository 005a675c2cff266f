"""What a scan may ask to be recorded, and which of it a scene can give."""

from __future__ import annotations

from collections.abc import Sequence

from nlds_vines.errors import RequestError, choice, shown
from nlds_vines.record import WANTS
from nlds_vines.scenes import Scene

_AT_WALLS = ("impacts", "clearance")
_ALL_EXACT = "method 'exact' discretises nothing of it, method 'rk4' does"


def checked_want(want: object) -> tuple[str, ...]:
    """Return a request for records in the order of `WANTS`.

    Raises `RequestError` unless it is a list of one or more different words of `WANTS`.
    """
    if isinstance(want, str) or not isinstance(want, Sequence):
        raise RequestError(f"want = {shown(want)} must be a list of words")
    if not want:
        raise RequestError(f"want = [] is an empty request; allowed: {', '.join(WANTS)}")
    words = [choice("want", word, WANTS) for word in want]
    if len(set(words)) < len(words):
        raise RequestError(f"want = {shown(words)} names something twice")
    return tuple(word for word in WANTS if word in words)


def possible_want(want: Sequence[str], scene: Scene, method: str = "exact") -> tuple[str, ...]:
    """Return what of `want` the scene can give by a method.

    Without walls there are neither impacts nor clearances, and nothing that `exact` discretises:
    only the methods of fixed steps have an error.
    """
    if scene.walls:
        return tuple(want)
    missing = (*_AT_WALLS, "error") if method == "exact" else _AT_WALLS
    return tuple(word for word in want if word not in missing)


def refuse_impossible(want: Sequence[str], scene: Scene, method: str = "exact") -> None:
    """Raise `RequestError` for the first of `want` that the scene cannot give by a method."""
    for word in want:
        if word not in possible_want(want, scene, method):
            why = f": {_ALL_EXACT}" if word == "error" else ""
            raise RequestError(
                f"want {word!r} cannot be had: kind {scene.kind!r} ({scene.meaning}) has no "
                f"wall{why}; allowed: {', '.join(possible_want(WANTS, scene, method))}"
            )
