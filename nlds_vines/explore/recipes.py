"""What one sees, as a file or a command that makes it: portrait recipe, scan file, command line."""

from __future__ import annotations

import base64
import shlex
from pathlib import Path
from tempfile import TemporaryDirectory

from nlds_vines.errors import RequestError
from nlds_vines.model.catalog import catalog
from nlds_vines.model.system import System
from nlds_vines.portrait.request import PortraitRequest
from nlds_vines.portrait.window_view import View

PORTRAIT, SCAN, PICTURE = "portrait.toml", "part.toml", "portrait.png"
"""The names under which a browser saves them."""


def portrait_command(request: PortraitRequest) -> str:
    """Return the command line that draws a portrait: without a file where a name suffices."""
    (column,) = request.columns
    named = _named(column.system)
    if named is None:
        return f"nlds-vines portrait {PORTRAIT}"
    words = ["nlds-vines", "portrait", *named]
    if request.start is not None:
        words.append(f"--start={','.join(repr(value) for value in request.start)}")
    words += ["--windows", f"{column.window.begin}:{column.window.end}"]
    words += ["--samples", str(request.samples)]
    if request.method != "exact":
        words += ["--method", request.method]
    elif request.tolerance not in (None, 1e-9):
        words += ["--tolerance", repr(request.tolerance)]
    return shlex.join(words)


def picture(request: PortraitRequest, view: View) -> str:
    """Return the portrait of an orbit as a picture (.png) in base64."""
    from nlds_vines.plotting.save import save_figure
    from nlds_vines.portrait.picture import portrait

    figure = portrait(request, [view])
    with TemporaryDirectory() as folder:
        path = Path(folder) / PICTURE
        save_figure(figure, path, request.title, ("recipe_hash", request.hash))
        return base64.b64encode(path.read_bytes()).decode()


def _named(system: System) -> list[str] | None:
    """Return --system and --set of a system of the catalog; None for any other."""
    base = catalog().get(system.name)
    if base is None or (base.kind, base.law, base.law_2) != (
        system.kind, system.law, system.law_2,
    ):  # fmt: skip
        return None
    changed = {k: v for k, v in system.parameters.items() if base.parameters.get(k) != v}
    try:
        same = base.with_(**changed).parameters == system.parameters
    except RequestError:
        return None
    if not same:
        return None
    words = ["--system", system.name]
    for name, value in changed.items():
        words += ["--set", f"{name}={value!r}"]
    return words
