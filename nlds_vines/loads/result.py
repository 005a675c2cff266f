"""A decay as an archive holds it: each damper by its name, and what it says in words."""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np

from nlds_vines.archives.archive import read
from nlds_vines.archives.archive_path import ArchivePath
from nlds_vines.errors import RequestError, choice, typed
from nlds_vines.loads.fall import SHARES, WAYS, Fall
from nlds_vines.loads.request import Decay
from nlds_vines.loads.request_file import load_decay
from nlds_vines.loads.run import HISTORIES, NUMBERS
from nlds_vines.model.words import system_in_words
from nlds_vines.orbits.status_words import OK, STATUS
from nlds_vines.plotting.drawable import Drawable
from nlds_vines.runs.manifest import DECAY


@dataclass(frozen=True)
class Decays(Drawable):
    """What becomes of a struck structure with each damper.

    Attributes:
        path: of the archive.
        request: with which the same numbers are computed again.
        falls: by the names of the systems, in the order of the request.

    Where there is one damper, `times` and `dissipated` are its own; of several, `found["tmd"]`
    gives one.
    """

    drawn_by = "nlds_vines.loads.picture"

    path: ArchivePath
    request: Decay
    falls: Mapping[str, Fall]

    def __getitem__(self, name: str) -> Fall:
        """Return what becomes of the structure with one damper, by the name of the system."""
        return self.falls[choice("damper", name, self.falls)]

    @property
    def failed(self) -> int:
        """Of how many dampers the orbit could not be followed to its end."""
        return sum(fall.status != OK for fall in self.falls.values())

    @property
    def times(self) -> dict[float, float]:
        """The last times [s] at which E1 exceeds shares of its largest; NaN: it still does."""
        return dict(zip(SHARES, self._only().last.tolist(), strict=True))

    @property
    def dissipated(self) -> dict[str, float]:
        """The shares of the energy that came in, which dashpots and contacts have dissipated."""
        return shares_of(self._only())

    def _only(self) -> Fall:
        if len(self.falls) > 1:
            raise RequestError(f"name the damper: [{next(iter(self.falls))!r}], of {[*self.falls]}")
        return next(iter(self.falls.values()))

    def lines(self) -> Iterator[str]:
        """Yield the title and a line for each damper."""
        yield self.request.title
        for system, fall in zip(self.request.systems, self.falls.values(), strict=True):
            if fall.status != OK:
                status = STATUS[fall.status]
                yield f"{system_in_words(system)}: {status.name}. {status.remedy}"
                continue
            last = ", ".join(
                f"{share:.0%} for {time:.4g} s" if np.isfinite(time) else f"{share:.0%} to the end"
                for share, time in zip(SHARES[::-1], fall.last[::-1], strict=True)
            )
            went = ", ".join(f"{way} {share:.1%}" for way, share in shares_of(fall).items())
            yield f"{system_in_words(system)}: E1 above {last}; dissipated by {went}"


def shares_of(fall: Fall) -> dict[str, float]:
    """Return the shares of the energy that came in, dissipated by the end, of what there is."""
    found = {way: float(fall.dissipated[way][-1]) / fall.numbers["energy_in"] for way in WAYS}
    return {way: share for way, share in found.items() if np.isfinite(share)}


@typed
def decays_in(path: str | os.PathLike[str]) -> Decays:
    """Return the decay in an archive; `RequestError` for an archive of anything else."""
    with read(path) as view:
        request = view.request(DECAY, load_decay)
        codes, last = view["status"], view["last"]

        def values(name: str, *dims: str) -> np.ndarray:
            shape = [len(codes), *(len(view[dim]) for dim in dims)]
            return view[name] if name in view else np.full(shape, np.nan)

        arrays = {name: values(name, "time") for name in HISTORIES}
        arrays |= {name: values(name) for name in NUMBERS}
        gone = {way: values(f"dissipated_{way}", "end") for way in WAYS}
        falls = {
            system.name: Fall(
                time=view["time"],
                ends=view["end"],
                dissipated={way: values[i] for way, values in gone.items()},
                last=last[i],
                numbers={name: float(arrays[name][i]) for name in NUMBERS},
                status=int(codes[i]),
                **{name: arrays[name][i] for name in HISTORIES},
            )
            for i, system in enumerate(request.systems)
        }
        return Decays(ArchivePath.of(view.path), request, falls)
