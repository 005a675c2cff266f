"""Notes in a wheel, or a source archive, of which commit it was built: archives name it."""

from __future__ import annotations

import subprocess
import tempfile
from pathlib import Path
from typing import Any

from hatchling.builders.hooks.plugin.interface import BuildHookInterface

NOTE = "commit.txt"
"""The file with the commit: beside this one in a source archive, among the data in a wheel."""


class CustomBuildHook(BuildHookInterface):
    """Adds the note, unless the commit is not known."""

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:
        """Add the note to what is built; an editable wheel asks git itself."""
        text = commit_of(Path(self.root))
        if not text or version == "editable":
            return
        self._folder = tempfile.TemporaryDirectory()
        path = Path(self._folder.name, NOTE)
        path.write_text(text, encoding="ascii")
        place = NOTE if self.target_name == "sdist" else f"nlds_vines/_data/{NOTE}"
        build_data["force_include"][str(path)] = place

    def finalize(self, version: str, build_data: dict[str, Any], artifact_path: str) -> None:
        """Remove what was made for it."""
        if hasattr(self, "_folder"):
            self._folder.cleanup()


def commit_of(root: Path) -> str:
    """Return the commit of a clone, with `+` for changes, or what is noted; "" if unknown."""
    note = root / NOTE
    if not (root / ".git").exists():
        return note.read_text(encoding="ascii").strip() if note.is_file() else ""
    try:
        found = _git(root, "rev-parse", "HEAD")
        changed = _git(root, "status", "--porcelain", "--untracked-files=no", "--", "nlds_vines")
    except (OSError, subprocess.SubprocessError):
        return ""
    return found + ("+" if changed else "")


def _git(root: Path, *arguments: str) -> str:
    command = ["git", "-C", str(root), *arguments]
    done = subprocess.run(command, capture_output=True, text=True, check=True, timeout=10)
    return done.stdout.strip()
