"""What the gallery shows of an example: the pictures that it has written."""

from __future__ import annotations

import shutil
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from sphinx_gallery.scrapers import figure_rst


def written_pictures(block: Any, variables: Mapping[str, Any], settings: Mapping[str, Any]) -> str:
    """Return the part of a page that shows the new PNG files beside an example.

    They are moved to the pictures of the gallery, so that each is shown once: below the code that
    has written it.
    """
    beside = Path(variables["src_file"]).parent
    shown = []
    for path in sorted(beside.glob("*.png"), key=lambda path: path.stat().st_mtime_ns):
        place = next(variables["image_path_iterator"])
        shutil.move(path, place)
        shown.append(place)
    return figure_rst(shown, settings["src_dir"])
