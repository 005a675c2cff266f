"""Where the files that travel with the package lie: inside a wheel, or beside it in a clone."""

from __future__ import annotations

from importlib.resources import files
from pathlib import Path

_FOLDER_IN_CLONE = {"dampers.toml": "data", "figure8.toml": "scans"}


def resource_text(name: str) -> str:
    """Return the text of the packaged file `name`, `dampers.toml` or `figure8.toml`.

    A wheel carries them in `nlds_vines/_data`; in a clone they stay in `data` and `scans`.
    """
    packed = files("nlds_vines") / "_data" / name
    if packed.is_file():
        return packed.read_text(encoding="utf-8")
    root = Path(__file__).resolve().parent.parent
    return (root / _FOLDER_IN_CLONE[name] / name).read_text(encoding="utf-8")
