"""One recorded number: its name, unit and words, where orbits hold it, and how it is drawn."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from nlds_vines.archives.dataset import Dataset
from nlds_vines.model.scenes import Scene

STRUCTURE = "structure"
"""The word for the body that is forced; kinds of one mass have another (`Scene.body`)."""

MAPS, CURVES, TOUCHED, BELOW = "maps", "curves", "touched", "below"
"""Where a number is drawn by default: on maps, the first that is recorded; in diagrams, from the
top, where no section is recorded; there, as the section at impact; below the other panels."""

SIGNED, ERROR, PERIOD, WAIT = "signed", "error", "period", "wait"
"""Scales: around zero; logarithmic, where zero is round-off; by colors of periods; logarithmic
from one period on."""

_LONGEST = 48  # characters of a label along an axis


@dataclass(frozen=True)
class Quantity:
    """One dataset of a scan: what it is, where its values are, and how it is drawn.

    Attributes:
        name: that of its dataset.
        unit: SI, in the notation of CF; "1" for a number without one.
        words: its meaning; {body} and {first} are the forced body, {x} and {v} its coordinates.
        record: the words of `quantities.RECORDS` with one of which it is recorded, the first being
            the one that a scene can give because it has this; () for always.
        label, symbol: on axes; by default the beginning of `words`, and none.
        has: which scenes have it; by default all.
        dims: the dimensions after `start`; `wall` only where there are two.
        dtype, fill: as in `archives.dataset.Dataset`.
        beside: what of these words has to be recorded too.
        buffer, column: where orbits hold it: a field of `batch.Outputs`, and the place in it, None
            for all of it; of what is stored for each wall, the first.
        of: in place of a column, the function of that buffer (chains, links, ...) that it is; of
            `section`, of the sampled periods.
        reduced: whether it is compared with that of the structure alone.
        drawn: of `MAPS`, `CURVES`, `TOUCHED` and `BELOW`.
        scale: of `SIGNED`, `ERROR`, `PERIOD` and `WAIT`; by default from the least to the largest.
        width: the name of half the width of its interval, drawn over a line at zero.
    """

    name: str
    unit: str
    words: str
    record: tuple[str, ...]
    label: str = ""
    symbol: str = ""
    has: Callable[[Scene], Any] = lambda scene: True
    dims: tuple[str, ...] = ()
    dtype: str = "float64"
    fill: float | int | str = np.nan
    beside: str = ""
    buffer: str = ""
    column: int | None = None
    of: Callable[[np.ndarray], np.ndarray] | None = None
    reduced: bool = False
    drawn: tuple[str, ...] = ()
    scale: str = ""
    width: str = ""

    @cached_property
    def single(self) -> bool:
        """Whether it is one number for each orbit, and no code and no word."""
        return not self.dims and self.dtype in ("float64", "int32")

    def title(self, body: str = STRUCTURE) -> str:
        """Return what it is in a few words and its symbol, as text; `body` as in `Scene.body`."""
        words = f"{self.label or clause(self.words)} {self.symbol}".replace("$", "").strip()
        return words.replace(STRUCTURE, body)

    def taken(self, values: np.ndarray) -> np.ndarray:
        """Return the values of this quantity from those of its buffer."""
        if self.of is not None:
            return self.of(values)
        return values if self.column is None else values[..., self.column]

    def dataset(
        self,
        dims: tuple[str, ...],
        scene: Scene,
        flags: Mapping[str, int] | None = None,
        prefix: str = "",
    ) -> Dataset:
        """Return its dataset over all of `dims`; before its name stands `prefix`."""
        name, words = f"{prefix}{self.name}", self.words_in(scene)
        return Dataset(name, dims, self.dtype, self.unit, words, self.fill, flags)

    def words_in(self, scene: Scene) -> str:
        """Return its meaning in a scene."""
        first = "primary structure" if scene.body == STRUCTURE else scene.body
        (x, v), by = scene.components[:2], "the motion of the foot" if scene.foot else "the force"
        frame = ", absolute" if scene.foot else ", relative to the ground" if scene.relative else ""
        return self.words.format(body=scene.body, first=first, x=x, v=v, by=by, frame=frame)


def clause(text: str) -> str:
    """Return what a text says before its first comma, semicolon or bracket, up to 48 characters."""
    clause = re.split(r"[,;:(]", text, maxsplit=1)[0].strip()
    return clause if len(clause) <= _LONGEST else clause[:_LONGEST].rpartition(" ")[0]
