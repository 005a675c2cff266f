"""What the gallery shows of an example: the pictures that it has written."""

from __future__ import annotations

import re
import shutil
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from sphinx_gallery.scrapers import figure_rst


def written_pictures(block: Any, variables: Mapping[str, Any], settings: Mapping[str, Any]) -> str:
    """Return the part of a page that shows the PNG files that a block of code names and wrote.

    They are moved to the pictures of the gallery. Other examples write theirs into the same folder
    at the same time.
    """
    beside = Path(variables["src_file"]).parent
    _, code, _ = block
    shown = []
    for path in (beside / name for name in re.findall(r'"([\w-]+\.png)"', code)):
        if path.exists():
            place = next(variables["image_path_iterator"])
            shutil.move(path, place)
            shown.append(place)
    return figure_rst(shown, settings["src_dir"])
