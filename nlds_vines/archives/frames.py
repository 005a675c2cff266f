"""An archive for other programs: labeled arrays of xarray, a table of pandas, a CSV file."""

from __future__ import annotations

import csv
import io
import os
from collections.abc import Mapping
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np

from nlds_vines.archives import durable
from nlds_vines.errors import RequestError, unknown

View = Any
"""An open archive, `view.ArchiveView`, which has these functions as methods."""

_COMPONENT = "component"  # whose values, x1, v1, x2, v2, become columns of their own


def columns_of(view: View, names: tuple[str, ...]) -> dict[str, np.ndarray]:
    """Return a table of an archive: columns by name, one row for each orbit or each further index.

    Arguments: `names` of datasets, none for all that have one value for each orbit.  The dimensions
    are the first columns; `section` becomes x1, v1, x2, v2, a row for each sampled period.
    """
    own = view.dims("status")
    chosen = names or tuple(name for name in view.names if view.dims(name) == own)
    for name in chosen:
        if name not in view.names:
            raise unknown(f"dataset of {view.path}:", name, view.names)
    longest = max((view.dims(name) for name in chosen), key=len)
    rows = tuple(dim for dim in longest if dim != _COMPONENT)
    shape = tuple(view.shape(dim)[0] for dim in rows)
    grid = np.meshgrid(*(view[dim] for dim in rows), indexing="ij")
    found = {dim: values.ravel() for dim, values in zip(rows, grid, strict=True)}
    for name in chosen:
        found |= _columns(view, name, rows, shape)
    return found


def _columns(
    view: View, name: str, rows: tuple[str, ...], shape: tuple[int, ...]
) -> Mapping[str, np.ndarray]:
    """Return the columns of one dataset; a code of an enumeration becomes its word."""
    dims, values = view.dims(name), view[name]
    inner = tuple(dim for dim in dims if dim != _COMPONENT)
    if any(dim not in rows for dim in inner):
        raise RequestError(
            f"{name} has the dimensions {', '.join(dims)}: it cannot stand in a table over "
            f"{', '.join(rows)}; take it alone"
        )
    if view.is_flag(name):
        words = {code: word.partition(".")[0] for code, word in view.flags(name).items()}
        if unknown_codes := set(values.flat) - set(words):
            code = min(unknown_codes)
            raise RequestError(f"{view.path}: {name} holds {code}, which means nothing: damaged")
        values = np.array([words[code] for code in values.ravel()], object).reshape(values.shape)
    wide = tuple(slice(None) if dim in inner else np.newaxis for dim in rows)
    if _COMPONENT not in dims:
        return {name: np.broadcast_to(values[wide], shape).ravel()}
    prefix = "" if name == "section" else f"{name}_"
    last = np.moveaxis(values, dims.index(_COMPONENT), -1)
    return {
        f"{prefix}{part}": np.broadcast_to(last[..., i][wide], shape).ravel()
        for i, part in enumerate(view[_COMPONENT])
    }


def write_csv(
    view: View, path: str | os.PathLike[str], names: tuple[str, ...], overwrite: bool
) -> None:
    """Write a table of an archive as comma-separated values; numbers keep all their digits.

    The first line has the names of the columns.  A file that exists is replaced with `overwrite`
    alone, and an archive never.  Raises `RequestError` otherwise.
    """
    if os.path.lexists(path) and not overwrite:
        raise RequestError(f"{path} exists: overwrite=True replaces it, another name keeps it")
    found = columns_of(view, names)
    text = io.StringIO(newline="")
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(found)
    writer.writerows(zip(*(column.tolist() for column in found.values()), strict=True))
    durable.write_text(Path(path), text.getvalue())


def frame_of(view: View, names: tuple[str, ...]) -> Any:
    """Return a table of an archive as a `pandas.DataFrame`; its columns' units are in `attrs`."""
    frame = library("pandas").DataFrame(columns_of(view, names))
    known = [name for name in frame.columns if name in view]
    frame.attrs = {"title": view.text("title"), "units": {n: view.units(n) for n in known}}
    return frame


def labeled(view: View) -> Any:
    """Return an archive as an `xarray.Dataset` in memory, with units, names and flags."""

    def entry(name: str) -> tuple[tuple[str, ...], np.ndarray, dict[str, Any]]:
        attributes: dict[str, Any] = {
            "units": view.units(name),
            "long_name": view.long_name(name),
        }
        if view.is_flag(name):
            words = view.flags(name)
            attributes |= {"flag_values": list(words), "flag_meanings": " ".join(words.values())}
        return view.dims(name), view[name], attributes

    dims = dict.fromkeys(dim for name in view.names for dim in view.dims(name))
    return library("xarray").Dataset(
        {name: entry(name) for name in view.names}, {dim: entry(dim) for dim in dims}, view.attrs
    )


def library(name: str) -> Any:
    """Return a library that is not always installed; `RequestError` where it is not."""
    try:
        return import_module(name)
    except ImportError:
        raise RequestError(
            f"{name} is not installed: pip install 'nlds-vines[xarray]' brings xarray and pandas"
        ) from None
