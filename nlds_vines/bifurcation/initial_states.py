"""Where the orbits of a scan begin that are not drawn: their states at phase zero of the force."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from nlds_vines.model.parameters import PHASE
from nlds_vines.orbits.starts import given_states
from nlds_vines.runs.progress import Tell

if TYPE_CHECKING:
    from nlds_vines.bifurcation.request import Scan


def begun(
    scan: Scan, cells: np.ndarray, initial: Mapping[str, np.ndarray], tell: Tell | None = None
) -> np.ndarray:
    """Return the states (n, 4), x1, v1, r, s, from which the orbits of cells count.

    Arguments: the `cells` (n,); the `initial` conditions that are not those of the scan's start,
    (n,) each, as `Scan.initial` has them; `tell` as `batch.Kernels` takes it.

    An orbit that begins at another phase is followed to the next section.
    """
    phases = initial.get(PHASE, np.full(len(cells), scan.start.phase))
    own = {name: values for name, values in initial.items() if name != PHASE}
    states = given_states(cells, scan.start, own, scan.system.scene)
    if PHASE not in initial and not scan.start.phase:
        return states
    from nlds_vines.orbits.phase_entry import Entries  # with kernels, which take long to load

    entries = Entries(scan.system.scene, scan.method, scan.settings, tell)
    return entries.at_section(cells, states, phases)
