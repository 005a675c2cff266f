"""Bifurcation and chaos analysis of vibro-impact nonlinear energy sinks.

    import nlds_vines as nv
    system = nv.load_system("ssul-set6", omega=7.45)
    orbit = nv.simulate(system, periods=100)
    nv.scan("scan.toml", to="scan.h5")

Everything is loaded when it is first used, so that asking for help costs nothing.  The types of the
public names stand in `__init__.pyi`.
"""

from __future__ import annotations

import sys
from importlib import import_module
from typing import Any

from nlds_vines.errors import renamed

if sys.platform == "win32":  # which has neither fcntl nor resource nor SIGUSR1
    _as_program = sys.argv[0] == "-m" or "nlds-vines" in sys.argv[0]  # then without a traceback
    raise (SystemExit if _as_program else ImportError)(
        "nlds_vines runs on Linux: on Windows, install it within WSL, which is one"
    )

_HOMES = {
    "RequestError": "errors",
    "System": "model.system",
    "load_system": "model.catalogue",
    "slow_manifold": "model.slow_manifold",
    "SlowManifold": "model.slow_manifold",
    "Scan": "bifurcation.request",
    "load_scan": "bifurcation.request_file",
    "Orbit": "orbits.simulation",
    "IntegrationError": "orbits.simulation",
    "simulate": "orbits.simulation",
    "Regime": "orbits.classification",
    "classify": "orbits.classification",
    "scan": "bifurcation.command",
    "orbit_of": "bifurcation.cell_orbit",
    "plot": "upkeep.plot",
    "ScanArchive": "bifurcation.result",
    "curves": "bifurcation.response_curves.command",
    "ResponseCurves": "bifurcation.response_curves.result",
    "Tuned": "tuning.result",
    "Tuning": "tuning.request",
    "load_tuning": "tuning.request_file",
    "tune": "tuning.command",
    "Continued": "continuation.result",
    "Continuation": "continuation.request",
    "follow": "continuation.command",
    "load_continuation": "continuation.request_file",
    "portray": "portrait.command",
    "decay": "loads.command",
    "Decay": "loads.request",
    "Decays": "loads.result",
    "load_decay": "loads.request_file",
    "ensemble": "transients.command",
    "Ensemble": "transients.ensemble",
    "ensemble_of": "transients.ensemble",
    "basin_measures": "transients.basin_shares",
    "Basins": "transients.basin_shares",
    "spectrum": "orbits.spectrum",
    "Spectrum": "orbits.spectrum",
    "open": "upkeep.opening",
    "read": "archives.archive",
    "verify": "archives.archive",
}

_OLD = {
    "continue_orbit": ("continuation.command", "follow"),
    "continued": ("continuation.result", "open"),
    "response_curves": ("bifurcation.response_curves.command", "curves"),
    "curves_in": ("bifurcation.response_curves.result", "open"),
}
"""Names that go with version 0.2: where each is, and what to call instead."""

_FOLDERS = "bifurcation", "portrait", "transients"
"""Folders that can be called (`callable_package`) until then."""

_MOVED = {"reproduce_paper": "in a clone, `paper.reproduce_paper` makes the paper's figures"}

__all__ = sorted([*_HOMES, "__version__"])


def __getattr__(name: str) -> Any:
    """Return a public name from the module that defines it."""
    if name == "__version__":
        from nlds_vines.archives.provenance import version

        return version("nlds-vines")
    if name in _FOLDERS:
        return import_module(f"{__name__}.{name}")
    if name in _OLD:
        home, new = _OLD[name]
        renamed(f"nv.{name}", f"nv.{new}")
        return getattr(import_module(f"{__name__}.{home}"), name)
    if name not in _HOMES:
        raise AttributeError(_MOVED.get(name) or f"module {__name__!r} has no attribute {name!r}")
    if _HOMES[name].startswith("orbits.") or name == "orbit_of":  # which loads Numba
        from nlds_vines.runs.threads import check_environment

        check_environment()
    module = import_module(f"{__name__}.{_HOMES[name]}")
    globals()[name] = value = getattr(module, name)
    return value


def __dir__() -> list[str]:
    """Return the public names."""
    return __all__
