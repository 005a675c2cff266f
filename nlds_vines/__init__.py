"""Bifurcation and chaos analysis of vibro-impact nonlinear energy sinks.

    import nlds_vines as nv
    system = nv.load_system("ssul-set6", omega=7.45)
    orbit = nv.simulate(system, periods=100)
    nv.scan("scan.toml", to="scan.h5")

Everything is loaded when it is first used, so that asking for help costs nothing.  The public names
stand in `__init__.pyi`, which tells their types as well.
"""

from __future__ import annotations

from importlib import import_module

TYPE_CHECKING = False
if TYPE_CHECKING:  # as `typing` has it, which a program loads when it can take signals
    from typing import Any


def _homes() -> dict[str, str]:
    """Return the modules in which public names are, as `__init__.pyi` says."""
    homes = {}
    with open(__file__.rpartition(".")[0] + ".pyi", encoding="ascii") as stub:
        for line in stub:
            if line.startswith(f"from {__name__}."):
                words = line.split()
                homes[words[3]] = words[1].removeprefix(f"{__name__}.")
    return homes


_HOMES = _homes()

__all__ = sorted({*_HOMES, "__version__"})


def __getattr__(name: str) -> Any:
    """Return a public name from the module that defines it."""
    if name == "__version__":
        from nlds_vines.archives.provenance import version

        return version("nlds-vines")
    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    if _HOMES[name].startswith("engine.") or name == "orbit_of":  # which loads Numba
        from nlds_vines.runs.executors import most_threads

        most_threads()
    value = getattr(import_module(f"{__name__}.{_HOMES[name]}"), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    """Return the public names."""
    return __all__
