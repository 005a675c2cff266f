"""What a map or a diagram may show, and in which colors; arrays and words, no picture."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from nlds_vines.bifurcation.picture.choices import COEXISTING, NUMBERS, REGIMES, SHARE
from nlds_vines.explore.map_data import TOUCHES, Stored
from nlds_vines.model.labels import (
    by_frequency,
    coexisting,
    finals,
    most_frequent,
    share_of,
)
from nlds_vines.model.quantities import BY_NAME, COORDINATES
from nlds_vines.model.quantity import ERROR
from nlds_vines.orbits.modulation import FLAGS as CAPTURE
from nlds_vines.plotting.palette import (
    COUNTS,
    HATCHED,
    OTHERS,
    RAMP,
    colors,
    drawn_as,
    ordered,
    short,
)

MOST_SHARES = 6
"""The most regimes of which the share of the starts can be shown."""

UNKNOWN = "not computed"
"""The word for a cell of a scan under way."""

FAILED_COLOR, UNKNOWN_COLOR = OTHERS["failed"], "#00000000"

COMPUTED = ((UNKNOWN, UNKNOWN_COLOR), ("computed", RAMP[0]), ("failed", FAILED_COLOR))
"""What is shown of a map that holds nothing else that a cell could show."""


@dataclass(frozen=True)
class Show:
    """One thing that a map may show.

    Attributes:
        name, title: as in `--show`, and in words.
        column: the numbers of the cells, a name of `cell_columns`, or of the section's component.
        of_start: whether there is one number for each start, and one start must be chosen.
        classes: (word, color) of each code of a column of codes, and of regimes the name of all
            of this color; empty for numbers.
        unit: of numbers; logarithmic: how they are colored.
        points: whether a diagram draws it as the points of a section.
    """

    name: str
    title: str
    column: str
    of_start: bool = True
    classes: tuple[tuple[str, ...], ...] = ()
    unit: str = "1"
    logarithmic: bool = False
    points: bool = False

    def plain(self) -> dict[str, Any]:
        """Return it as a browser takes it."""
        return {**vars(self), "classes": [list(pair) for pair in self.classes]}


STATUS_SHOW = Show("status", "status", "computed", classes=COMPUTED)
"""The show of a scan, or of a page, that holds nothing else to color cells by."""


def shows_of(found: Stored) -> list[Show]:
    """Return what the map or the diagram of a scan may show, the usual one first."""
    several = len(found.starts) > 1
    maps = len(found.scan.axes) == 2
    shows = [*_sections(found), *_touches(found)] if not maps else []
    if "label" in found and maps:
        classes = classes_of(found)
        if several:
            shows.append(Show(REGIMES, "regimes, most frequent", "most", False, classes))
        shows.append(
            Show(f"{REGIMES} of a start" if several else REGIMES, "regimes of a start" if several
                 else "regimes", "label", classes=classes)
        )  # fmt: skip
        if several:
            shows += [*_of_several(found)]
    return [*shows, *_codes(found, maps), *_numbers(found)] or [STATUS_SHOW]


def _sections(found: Stored) -> list[Show]:
    """Return the displacements of a recorded section."""
    if "section" not in found:
        return []
    names = [n for n in ("x2", "x1", "x") if n in found.scan.system.scene.components]
    titles = {name: f"displacement {COORDINATES[name][1]} of the section" for name in names}
    return [Show(n, titles[n], f"section {n}", unit="m", points=True) for n in names]


def _touches(found: Stored) -> list[Show]:
    """Return the numbers of each touch, the section at impact."""
    every = ((name, BY_NAME[name]) for name in TOUCHES if name in found)
    return [
        Show(name, one.title(), f"section {name}", unit=one.unit, points=True)
        for name, one in every
    ]


def _codes(found: Stored, maps: bool) -> list[Show]:
    """Return the kind of modulation, on a map, where it is recorded."""
    if not maps or "capture" not in found:
        return []
    words = [word.replace("_to_", ":").replace("_", " ") for word in CAPTURE]
    classes = ((UNKNOWN, UNKNOWN_COLOR), *zip(words, COUNTS, strict=False))
    return [Show("capture", "response by impacts a period", "capture", classes=classes)]


def _of_several(found: Stored) -> list[Show]:
    """Return what there is to see of several starts in a cell."""
    last = len(COUNTS)
    words = [(f"{n} or more" if n == last else str(n), COUNTS[n - 1]) for n in range(1, last + 1)]
    counts = (("none known", OTHERS[HATCHED]), *words)
    shows = [Show(COEXISTING, "how many regimes coexist", "coexisting", False, counts)]
    for label in shared_labels(found):
        name = f"{SHARE}{label}"
        shows.append(Show(name, f"share of the starts in {label}", name, False))
    return shows


def _numbers(found: Stored) -> list[Show]:
    """Return the recorded numbers."""
    body = found.scan.system.scene.body
    every = ((name, BY_NAME[name]) for name in NUMBERS if name in found)
    return [
        Show(name, one.title(body), name, unit=one.unit, logarithmic=one.scale == ERROR)
        for name, one in every
    ]


def shared_labels(found: Stored) -> list[str]:
    """Return the final regimes that are most frequent, known ones only."""

    def make() -> list[str]:
        ends = finals(found.arrays["label"])
        return [word for word, _ in by_frequency(ends) if word][:MOST_SHARES]

    shared: list[str] = found.once("shared labels", make)
    return shared


def label_words(found: Stored) -> list[str]:
    """Return the different labels by their codes: code 0 is a cell that is not computed."""
    words, _ = label_places(found)
    return words


def label_places(found: Stored) -> tuple[list[str], np.ndarray]:
    """Return the different labels as `label_words` has them, and the code of each orbit's."""

    def make() -> tuple[list[str], np.ndarray]:
        words, index = np.unique(found.arrays["label"].astype(np.str_), return_inverse=True)
        several = len(found.starts) > 1
        more = set(np.unique(_frequent(found).astype(np.str_)).tolist()) if several else set()
        every = [UNKNOWN, *ordered({*words.tolist(), *more} - {""})]
        code = {word: i for i, word in enumerate(every)} | {"": 0}
        codes = np.array([code[word] for word in words.tolist()])
        return every, codes[index.ravel()].astype(np.uint16)

    found_here: tuple[list[str], np.ndarray] = found.once("labels", make)
    return found_here


def classes_of(found: Stored) -> tuple[tuple[str, ...], ...]:
    """Return the words of all labels, in the order of their codes, with their colors.

    Beside them stands the name that all regimes of this color share.
    """
    _, *words = label_words(found)
    shades = colors(words)
    named = ((short(word), shades[word], short(drawn_as(word))) for word in words)
    return ((UNKNOWN, UNKNOWN_COLOR, UNKNOWN), *named)


def columns_of_shows(found: Stored) -> dict[str, np.ndarray]:
    """Return the columns that must be computed first: a number for each cell (cells,).

    They are the codes of the most frequent regimes, how many regimes coexist, and shares.
    """
    if "label" not in found or len(found.starts) < 2 or len(found.scan.axes) < 2:
        return {}
    labels = found.lanes("label")
    code = {word: i for i, word in enumerate(label_words(found))}
    words = _frequent(found).ravel()
    columns = {
        "most": np.array([code.get(str(word), 0) for word in words]),
        "coexisting": np.minimum(coexisting(labels), len(COUNTS)),
    }
    return columns | {f"{SHARE}{one}": share_of(labels, one) for one in shared_labels(found)}


def _frequent(found: Stored) -> np.ndarray:
    """Return the most frequent label of each cell; empty where one is not computed yet."""

    def make() -> np.ndarray:
        labels = found.arrays["label"]
        return np.where((labels == "").any(axis=-1), "", most_frequent(labels))

    frequent: np.ndarray = found.once("frequent", make)
    return frequent
