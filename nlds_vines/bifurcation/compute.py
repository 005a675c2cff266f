"""One block of cells through the kernels: from numbers to the arrays of an archive."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from nlds_vines.archives.dataset import Dataset
from nlds_vines.bifurcation.cell_start import STEP, own_states
from nlds_vines.kernels.scene.scene import Span
from nlds_vines.model.linear_response import energy_alone
from nlds_vines.model.quantities import BY_NAME
from nlds_vines.orbits import responses
from nlds_vines.orbits.batch import Kernels, Outputs, Wanted
from nlds_vines.orbits.records import ATTRACTOR, OK, modulation_of, plain
from nlds_vines.orbits.solver_settings import Settings
from nlds_vines.orbits.spectral_values import agreement, arrays_of
from nlds_vines.orbits.starts import start_states, user_states
from nlds_vines.runs.progress import Tell

if TYPE_CHECKING:
    from nlds_vines.bifurcation.attractor_ends import OrbitEnds
    from nlds_vines.bifurcation.blocks import Block
    from nlds_vines.bifurcation.request import Scan


def wanted_of(scan: Scan, settings: Settings | None = None) -> Wanted:
    """Return what a scan wants of orbits to their end; `settings` None means its own."""
    settings = scan.settings if settings is None else settings
    return Wanted(scan.system.scene, plain(scan.want), scan.method, scan.effort, settings)


class Computer:
    """Computes blocks of one scan; what all blocks share is prepared once."""

    def __init__(
        self,
        scan: Scan,
        settings: Settings | None = None,
        tell: Tell | None = None,
        *,
        helped: bool = True,
    ) -> None:
        """Prepare the cells and starts of `scan`; by default with its own settings.

        Arguments: `tell` and `helped` as `batch.Kernels` takes them.
        """
        self.scan = scan
        self._cells, self._tell = scan.cells(), tell
        self._draws = start_states(scan.start) if scan.start.policy == "random" else None
        wanted = wanted_of(scan, settings)
        self.ends: OrbitEnds | None = None
        if ATTRACTOR in scan.want:
            from nlds_vines.bifurcation.attractor_ends import OrbitEnds  # with SciPy's searches

            self.ends = OrbitEnds(scan, wanted, tell, helped=helped)
        self._kernels = Kernels(wanted, tell, helped=helped)
        self._spectral, self._traced = scan.spectral, None
        if self._spectral is not None:
            traced = replace(wanted, want=("section",))
            self._traced = Kernels(traced, tell, helped=helped)

    def block(self, block: Block) -> dict[str, np.ndarray]:
        """Return the datasets of a block by name, each of shape rectangle + (starts,) + tail."""
        cells = self._cells[block.selection]
        sides = (np.arange(first, stop) for first, stop in block.slices)
        places = np.ravel_multi_index(np.ix_(*sides), self.scan.shape)
        arrays = self.lanes(*self._chains(cells, places))
        return {
            name: self._in_place(arrays[name], cells.shape, name)
            for name in self.scan.table.datasets
        }

    def lanes(
        self, chains: np.ndarray, starts: np.ndarray, places: np.ndarray | None = None
    ) -> dict[str, np.ndarray]:
        """Return the results of chains of cells (chains, links) from their starts (chains, 4).

        Arguments: `places` (chains,), the number in the scan of the first cell of each, which
        attractors need; by default the first one.

        They are arrays (chains, links, tail) by name of the dataset; there may be more of them than
        the scan wants.
        """
        arrays = {"P": chains["P"].copy()}
        if self._draws is not None:
            states = user_states(chains[:, 0], starts, self.scan.system.scene)
            arrays["start_state"] = states[:, np.newaxis]
        arrays |= self._spectra(chains, starts)
        if self.ends is not None:
            where = np.zeros(len(chains), np.int64) if places is None else places
            arrays |= self.ends.arrays(chains[:, 0], starts, where)
        if self._kernels.records or "status" not in arrays:
            outputs = self.run(chains, starts, self.scan.transient, self.scan.periods)
            arrays |= self._arrays(outputs, chains)
        if "spectra_agree" in self.scan.table.datasets:
            arrays["spectra_agree"] = agreement(
                arrays["regime"],
                arrays["periodicity"],
                arrays["spectral_label"],
                self.scan.periods,
            )
        for name, dataset in self.scan.table.datasets.items():
            _one_nan(_failed_filled(arrays[name], dataset, arrays["status"]))
        return arrays

    def run(self, chains: np.ndarray, starts: np.ndarray, transient: int, periods: int) -> Outputs:
        """Run chains of cells (chains, links) from `starts` (chains, 4) on the current threads."""
        return self._kernels.run(chains, starts, transient, periods)

    def _spectra(self, chains: np.ndarray, starts: np.ndarray) -> dict[str, np.ndarray]:
        """Return what is recorded of spectra, by name: of the same orbits, at more instants.

        And how they ended, which counts where nothing else is recorded.
        """
        if self._spectral is None or self._traced is None:
            return {}
        span = Span(self.scan.transient, self.scan.periods, self._spectral.samples)
        states, status = self._traced.states(chains, starts, span)
        arrays = arrays_of(self._spectral, states, status == OK, self.scan.transient)
        return {"status": status, **arrays}

    def orbits(self, chosen: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return orbits of the scan, each by itself: cells (n, 1), starts (n, 4), places (n,).

        Arguments: the numbers (n,) of the `chosen` ones, counted cell after cell.  Those of a sweep
        begin at rest here.
        """
        places, lanes = np.divmod(chosen, self.scan.starts)
        where = np.unravel_index(places, self.scan.shape)
        cells = self._cells[where]
        states = own_states(self.scan, cells, where, lanes, self._draws, self._tell)
        return cells[:, np.newaxis], states, places

    def _chains(
        self, cells: np.ndarray, places: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return the chains of a block of cells, the start (x1, v1, r, s) and place of each."""
        if sweeps := self.scan.start.sweeps:
            rows = cells.reshape(-1, cells.shape[-1])
            chains = np.concatenate([rows[:, :: STEP[sweep]] for sweep in sweeps])
            firsts = np.tile(places.reshape(rows.shape)[:, 0], len(sweeps))
            return chains, np.zeros((len(chains), 4)), firsts
        numbers = places.reshape(-1, 1) * self.scan.starts + np.arange(self.scan.starts)
        return self.orbits(numbers.ravel())

    def _arrays(self, outputs: Outputs, cells: np.ndarray) -> dict[str, np.ndarray]:
        """Return the datasets by name, in the order of the lanes: (chains, links, tail)."""
        status = outputs.status
        arrays = {"status": status}
        for name in self.scan.table.datasets:
            entry = BY_NAME[name]
            buffer = getattr(outputs, entry.buffer) if entry.buffer in _PLAIN else None
            if buffer is not None:
                if entry.buffer == "section":
                    buffer = buffer[:, :, -self.scan.periods :]
                with np.errstate(all="ignore"):  # lanes that failed hold anything
                    arrays[name] = entry.taken(buffer)
        if "reduction" in self.scan.table.datasets:
            with np.errstate(all="ignore"):  # without a force nothing can be reduced: NaN
                arrays["reduction"] = 1.0 - arrays["E1max"] / energy_alone(cells)
        if outputs.response is not None:
            arrays |= responses.arrays_of(outputs.response, self.scan.system.scene, cells)
        if outputs.cycle is not None:
            arrays["periodicity"], by_wall = outputs.cycle[..., 0], outputs.cycle[..., 1:]
            arrays["impact_count"], arrays["impacts_by_wall"] = by_wall.sum(axis=-1), by_wall
        if outputs.counts is not None:
            arrays["impact_rate"] = outputs.by_wall.sum(axis=-1) / self.scan.periods
        if outputs.counts is not None and "modulation" in self.scan.want:
            assert outputs.section is not None
            section = outputs.section[:, :, -self.scan.periods :]
            with np.errstate(all="ignore"):  # lanes that failed hold anything
                arrays |= modulation_of(section, cells["omega"], outputs.counts)
        if outputs.evidence is not None:
            arrays |= outputs.verdicts(cells)
        return arrays

    def _in_place(self, values: np.ndarray, shape: tuple[int, ...], name: str) -> np.ndarray:
        """Return values of lanes in the block's shape, failed lanes at their fill value."""
        if sweeps := self.scan.start.sweeps:
            passes = values.reshape(len(sweeps), -1, *values.shape[1:])
            ordered = (one[:, :: STEP[sweep]] for one, sweep in zip(passes, sweeps, strict=True))
            values = np.stack(list(ordered), axis=2)
        tail = self.scan.table.shape(name)[len(self.scan.axes) :]
        return values.reshape(*shape, *tail)


_PLAIN = ("section", "energy", "peak", "violation", "touches", "clearance")
"""The buffers of `Outputs` whose numbers are recorded as they are."""

_KNOWN = ("status", "regime", "label", "start_state")
"""The datasets that also say something of an orbit that failed."""


def _one_nan(values: np.ndarray) -> None:
    """Let every NaN be the same: the sign of one that is computed depends on the processor."""
    if values.dtype.kind == "f":
        values[np.isnan(values)] = np.nan


def _failed_filled(values: np.ndarray, dataset: Dataset, status: np.ndarray) -> np.ndarray:
    """Return the values, those of failed lanes replaced by the fill value, but for `_KNOWN`."""
    failed = status != OK
    if dataset.name not in _KNOWN and failed.any():
        values[failed] = dataset.fill
    return values
