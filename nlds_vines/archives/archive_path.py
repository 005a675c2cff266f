"""The path of an archive, which can be read; one without a name lives as long as its path does."""

from __future__ import annotations

import os
import shutil
import tempfile
import weakref
from contextlib import AbstractContextManager
from pathlib import Path
from typing import TYPE_CHECKING, Any

from nlds_vines.errors import RequestError, shown

if TYPE_CHECKING:
    from nlds_vines.archives.view import ArchiveView


class _Folder:
    """A folder for the time in which somebody holds this object."""

    def __init__(self) -> None:
        self.path = Path(tempfile.mkdtemp(prefix="nlds_vines-"))
        weakref.finalize(self, shutil.rmtree, self.path, ignore_errors=True)


class ArchivePath(type(Path())):  # type: ignore[misc]  # the concrete class: Path alone is abstract
    """The path of an archive; wherever a path may stand, it may stand.

    An archive that nobody gave a name lies in a folder of its own, which goes with the last path
    that knows it; pickled, it takes its content along.
    """

    _folder: _Folder | None = None

    @classmethod
    def of(cls, path: str | os.PathLike[str]) -> ArchivePath:
        """Return a path as that of an archive."""
        found = cls(path)
        found._folder = getattr(path, "_folder", None)
        return found

    @classmethod
    def for_result(
        cls, to: str | os.PathLike[str] | None, stem: str, *options: bool
    ) -> ArchivePath:
        """Return where a result goes: to a file of the user's, or nowhere that lasts.

        Arguments: the file; `stem`, what it is called where there is none; `options` that mean
        something for a file alone, as resume and overwrite.

        Raises `RequestError` for such an option without a file.
        """
        if to is not None and not isinstance(to, str | os.PathLike):
            raise RequestError(f"to = {shown(to)} must be the path of an archive (.h5)")
        if to is not None:
            return cls.of(to)
        if any(options):
            raise RequestError("resume and overwrite belong to an archive: name it by to=")
        folder = _Folder()
        found = cls(folder.path / f"{stem}.h5")
        found._folder = folder
        return found

    @property
    def named(self) -> ArchivePath | None:
        """The path itself; None for an archive without a name."""
        return self if self._folder is None else None

    def read(self) -> AbstractContextManager[ArchiveView]:
        """Open it, in a `with` statement, as `nlds_vines.read` does."""
        from nlds_vines.archives.archive import read

        return read(self)

    def to_xarray(self) -> Any:
        """Return all that it holds as an `xarray.Dataset` in memory, with units and words."""
        with self.read() as view:
            return view.to_xarray()

    def to_dataframe(self, *names: str) -> Any:
        """Return datasets, by default those of one value a row, as a `pandas.DataFrame`."""
        with self.read() as view:
            return view.to_pandas(*names)

    def __reduce__(self) -> tuple[Any, ...]:
        """Pickle the path; of an archive without a name, what it holds."""
        if self._folder is None:
            return type(self), (str(self),)
        return _unpickled, (type(self), self.stem, self.read_bytes())


def _unpickled(kind: type[ArchivePath], stem: str, content: bytes) -> ArchivePath:
    found = kind.for_result(None, stem)
    found.write_bytes(content)
    return found


class Archived:
    """A result of which an archive holds everything: its `path`, None where it has none."""

    path: ArchivePath | None

    @property
    def archive(self) -> ArchivePath:
        """Its archive; `RequestError` for a result that was made without one."""
        if self.path is None:
            raise RequestError(f"this {type(self).__name__} has no archive: it was made of arrays")
        return self.path

    def to_xarray(self) -> Any:
        """Return all that the archive holds as an `xarray.Dataset` in memory."""
        return self.archive.to_xarray()

    def to_dataframe(self, *names: str) -> Any:
        """Return datasets, by default those of one value a row, as a `pandas.DataFrame`."""
        return self.archive.to_dataframe(*names)
