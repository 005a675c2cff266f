"""Maps of what orbits are by a code, as the kind of a modulated response: a colour for each."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Patch

from nlds_vines.archives.archive import ArchiveView
from nlds_vines.bifurcation.picture.map_panel import add_map_legend, fill_classes
from nlds_vines.model.quantity import clause
from nlds_vines.plotting.page import Page
from nlds_vines.plotting.palette import COUNTS
from nlds_vines.plotting.style import GREY, NO_VALUE


def fill_codes(axes: Axes, view: ArchiveView, name: str, page: Page) -> None:
    """Fill every cell with the colour of its code, of several starts the highest; with a legend.

    Colours go from pale to dark in the order of the codes, and begin anew where they are many.
    """
    codes, words = view[name].max(axis=-1), view.flags(name)
    found = sorted(set(codes.ravel().tolist()))
    shades = {code: COUNTS[i % len(COUNTS)] for i, code in enumerate(sorted(words))}
    looks = {code: shades.get(code, NO_VALUE) for code in found}
    fill_classes(axes, view, codes, found, list(looks.values()))
    frame: dict[str, Any] = {"edgecolor": GREY, "linewidth": 0.4}  # the first is nearly white
    handles = [
        Patch(facecolor=colour, label=_in_words(words.get(code, "none")), **frame)
        for code, colour in looks.items()
    ]
    title = clause(view.long_name(name))
    several = f"\nhighest of {view['start'].size} starts" if view["start"].size > 1 else ""
    add_map_legend(axes, handles, _broken(title) + several, page)


def _in_words(flag: str) -> str:
    """Return a flag as a legend has it: `sustained 1:1` of `sustained_1_to_1`."""
    return flag.partition(".")[0].replace("_to_", ":").replace("_", " ")


def _broken(text: str) -> str:
    """Return a title in two lines of about one length, as a legend has room for."""
    words = text.split(" ")
    ends = np.cumsum([len(word) + 1 for word in words])
    half = int(np.argmin(np.abs(ends - ends[-1] / 2))) + 1
    return "\n".join(filter(None, (" ".join(words[:half]), " ".join(words[half:]))))
