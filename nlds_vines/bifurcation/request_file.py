"""A scan file (TOML), as pages of response curves read it."""

from __future__ import annotations

from nlds_vines.bifurcation.request import Scan
from nlds_vines.bifurcation.request import load_scan as load_scan
from nlds_vines.model.request_layers import Form
from nlds_vines.model.setting import checks
from nlds_vines.orbits.starts import Start

FORM = Form(
    kind="scan",
    tables={"set": None, "vary": None, **checks(Start, Scan)},
    names=False,
    sources="a path, a name, a table, a System or a Scan",
)
