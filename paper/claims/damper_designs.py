"""Section 2: designs of the damper (Figure 1), and the surface on which it strikes."""

from __future__ import annotations

import numpy as np

from nlds_vines.model.catalog import catalog
from paper.claims.claim import (
    Claim,
    Finding,
    by_name,
    decided,
    listed,
    tuning_frequency,
    weighed,
)
from paper.claims.measured import Data, Evidence
from paper.claims.parameter_sets import SAME_CURVE, SET6
from paper.claims.retention import name
from paper.claims.three_dampers import absorber
from paper.linear import response

MODULI = (2.05e6, 2.05e7, 2.05e8, 2.05e9, 2.1e11)
"""Values of E2 [Pa], chosen here: the paper's, softer, and harder up to that of the obstacle."""

MOST = 0.5  # of the frequencies with impacts, least share at which both walls are struck


def _both_sides(evidence: Evidence) -> Finding:
    data = evidence("3", "ssbl")
    counts, rates = data["impacts_by_wall"], data["impact_rate_by_wall"]
    is_periodic = data["periodicity"][:, np.newaxis] > 0
    struck = np.where(is_periodic, counts > 0, rates > 0)
    some, both = int(struck.any(axis=1).sum()), int(struck.all(axis=1).sum())
    alone = (struck & (struck.sum(axis=1) == 1)[:, np.newaxis]).sum(axis=0)
    walls = zip(data.system.scene.walls, alone.tolist(), strict=True)
    words = (f"the {data.system.scene.struck[wall]} alone at {count}" for wall, count in walls)
    text = f"of the {some} frequencies with impacts both at {both}, {', '.join(words)}"
    return weighed(text, both > 0, both > MOST * some)


def _model_1b(evidence: Evidence) -> Finding:
    data, tuned = evidence("model-1b"), tuning_frequency()
    names = (SET6, "ssbl", "tmd")
    others = {other: evidence("3", other).at(tuned) for other in names}
    energy = np.where(data["violations"] == 0, data["E1max"], np.inf)
    admissible = int(np.isfinite(energy).sum())
    if not admissible:
        return decided(True, f"none of {energy.size} designs keeps x1 < x2")
    best = float(energy.min())
    p = data.system.parameters
    text = (
        f"{admissible} of {energy.size} designs with D = {p['D']:g} m, C = {p['C']:g} m keep "
        f"x1 < x2; the best, {_place(data, energy)}, has {best:.0f} J at {tuned:g} rad/s against "
        f"{by_name({key: [E] for key, E in others.items()}, '.0f')} J; {_without_limit(tuned)}"
    )
    return weighed(text, best > others[SET6], best > max(others["ssbl"], others["tmd"]))


def _place(data: Data, energy: np.ndarray) -> str:
    """Return the parameters of the design with the least energy on a map."""
    place = np.unravel_index(int(energy.argmin()), energy.shape)
    pairs = zip(data.axes.items(), place, strict=True)
    return ", ".join(f"{key} = {values[i]:.4g}" for (key, values), i in pairs)


def _without_limit(omega: float) -> str:
    """Return what this model is where D is so large that it is never reached."""
    tmd = absorber(catalog()["tmd"], omega)
    free = response(tmd, np.array([omega]))
    return (
        f"with D above {free.shortening[0]:.2f} m, which the paper does not exclude, it can be a "
        f"TMD of {free.E1max[0]:.0f} J (closed form)"
    )


def _surfaces(evidence: Evidence) -> dict[str, tuple[list[float], list[float]]]:
    """Return of two dampers the peaks and the energies where tuned [J], a value for each E2."""
    found = {}
    for damper in (SET6, "ssbl"):
        curves = [evidence("surface", name(damper, "E2", E2)) for E2 in MODULI]
        tuned = [data.at(tuning_frequency()) for data in curves]
        found[damper] = [data.peak()[0] for data in curves], tuned
    return found


def _shown_surfaces(found: dict[str, tuple[list[float], list[float]]]) -> str:
    peaks = by_name({damper: rows[0] for damper, rows in found.items()}, ".0f")
    tuned = by_name({damper: rows[1] for damper, rows in found.items()}, ".1f")
    return f"E2 = {listed(MODULI)} Pa: peaks {peaks} J; at {tuning_frequency():g} rad/s {tuned} J"


def _printed() -> int:
    return MODULI.index(catalog()[SET6].parameters["E2"])


def _soft_better(evidence: Evidence) -> Finding:
    found, place = _surfaces(evidence), _printed()
    rows = [row for pair in found.values() for row in pair]
    return weighed(_shown_surfaces(found), *(row[place] < row[-1] for row in rows))


def _soft_optimal(evidence: Evidence) -> Finding:
    found, place = _surfaces(evidence), _printed()
    rows = [row for pair in found.values() for row in pair]
    best = [row[place] <= (1 + SAME_CURVE) * min(row) for row in rows]
    words = (
        f"{damper} by peak {_excess(peaks)}, where tuned {_excess(tuned)}"
        for damper, (peaks, tuned) in found.items()
    )
    return weighed(f"above the least of all values: {'; '.join(words)}", *best)


def _excess(energies: list[float]) -> str:
    """Return by how much the printed E2 exceeds the best one, and which that is, in words."""
    best = int(np.argmin(energies))
    return f"{100 * (energies[_printed()] / energies[best] - 1):.1f} % (at {MODULI[best]:g} Pa)"


def _softer_impact(evidence: Evidence) -> Finding:
    both = sorted(evidence.motions("impact"), key=lambda motion: motion.system.K)
    forces = [float(motion.forces.max(initial=0.0)) for motion in both]
    longest = [1000 * float(motion.durations.max(initial=0.0)) for motion in both]
    moduli = listed([motion.system.parameters["E2"] for motion in both])
    text = (
        f"at {tuning_frequency():g} rad/s, E2 = {moduli} Pa: largest force "
        f"{listed(forces, '.4g')} N, longest contact {listed(longest, '.3g')} ms"
    )
    return decided(0 < forces[0] < forces[1] and longest[0] > longest[1], text)


DESIGNS = (
    Claim(
        "2",
        "The SSbl NES strikes the obstacle and the structure.",
        "3",
        _both_sides,
        f"both at more than {100 * MOST:g} % of the frequencies with impacts",
    ),
    Claim(
        "2",
        "The NES that must not reach the structure (Figure 1b) hardly mitigates.",
        "model-1b",
        _model_1b,
        "where tuned, no better than the SSul NES, nor than SSbl NES and TMD",
    ),
    Claim(
        "2, 6",
        "A soft surface of the damper is better than one as hard as the obstacle.",
        "surface",
        _soft_better,
        "lower by peak and where tuned, both NES",
    ),
    Claim(
        "2, 6",
        "E2 = 2.05e7 Pa is the optimum.",
        "surface",
        _soft_optimal,
        f"within {100 * SAME_CURVE:g} % of the least, by peak and where tuned, both NES",
    ),
    Claim("2, 6", "A soft surface makes impacts softer.", "impact", _softer_impact),
)
"""The claims of Section 2 about designs, and of Section 6 about the surface."""
