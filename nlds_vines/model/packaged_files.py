"""The paths of packaged files: inside a wheel, or beside the package in a clone."""

from __future__ import annotations

from importlib.resources import files
from pathlib import Path

# all others lie in `scans`
_FOLDER_IN_CLONE = {"dampers.toml": "data", "states.json": "data/reference"}
_FIGURES = ("figure*.toml", "study-*.toml")


def resource_text(name: str) -> str:
    """Return the text of the packaged file `name`: `dampers.toml`, a request file, `states.json`.

    A wheel holds them in `nlds_vines/_data`; in a clone they stay in `data` and `scans`.
    """
    return resource_path(name).read_text(encoding="utf-8")


def resource_path(name: str) -> Path:
    """Return the path of the packaged file `name`, which need not exist."""
    packed = _packed() / name
    if packed.is_file():
        return packed
    return _clone() / _FOLDER_IN_CLONE.get(name, "scans") / name


def figure_files() -> list[Path]:
    """Return the request files in the package: the paper's figures, and studies of our own."""
    folder = _packed() if _packed().is_dir() else _clone() / "scans"
    return sorted(path for pattern in _FIGURES for path in folder.glob(pattern))


def _packed() -> Path:
    """Return the folder of the files in an installed wheel; a clone has none."""
    return Path(str(files("nlds_vines") / "_data"))


def _clone() -> Path:
    return Path(__file__).resolve().parents[2]
