"""The names of regimes written into the regions of a map, where they are large enough."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from matplotlib.axes import Axes

from nlds_vines.archives.archive import ArchiveView
from nlds_vines.plotting.palette import is_dark, short
from nlds_vines.plotting.panels import size_of, text_width

_SIZE = 7  # pt
_PADDING = 4  # pt between a name and the border of its region
_LONGEST = 14  # characters of a name that is written inside


def name_regions(
    axes: Axes, view: ArchiveView, names: np.ndarray, shades: Mapping[str, str]
) -> None:
    """Write each name once into the largest circle of cells of that name, if it fits there.

    Arguments: the axes of the map; its archive; the `names` (first parameter, second parameter) of
    its cells; the colours of those that are to be written, by name.
    """
    from scipy.ndimage import distance_transform_edt

    wide, tall = size_of(axes)
    sides = wide / names.shape[0], tall / names.shape[1]
    for word, colour in shades.items():
        text = short(word)
        if len(text) > _LONGEST:
            continue
        inside = np.pad(names == word, 1)
        depth = distance_transform_edt(inside, sampling=sides)[1:-1, 1:-1]
        place = np.unravel_index(np.argmax(depth), depth.shape)
        if text_width(text, _SIZE) / 2 + _PADDING > depth[place]:
            continue
        x, y = (view[name][index] for name, index in zip(view.axes, place, strict=True))
        ink = "white" if is_dark(colour) else "black"
        axes.text(x, y, text, color=ink, fontsize=_SIZE, ha="center", va="center")
