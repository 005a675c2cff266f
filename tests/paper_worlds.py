"""Invented worlds: in some a claim of the paper holds, in others it does not."""

import numpy as np
import paper_results

from nlds_vines.model.system import System


def rising(system, omega):
    return omega + 40 * len(system.name) - system.parameters.get("c2", 300) * 0.1


def better(system, omega):
    """Return the published energies where the program agrees, others where it contradicts."""
    p = system.parameters
    if p.get("k2") == 2083:
        return paper_results.published(system, omega) * 5
    if system.kind == "ssul":
        return paper_results.published(system, omega) * 0.8
    if system.kind == "tmd" and p["k1"] < paper_results.TUNED_K1:
        return paper_results.published(system, omega) * (
            1 + 1.5 * (1 - p["k1"] / paper_results.TUNED_K1)
        )
    return paper_results.published(system, omega)


def unlike(system, omega):
    """Return energies of dampers that differ from one another and from the paper."""
    p, base = system.parameters, paper_results.published(system, omega)
    if system.kind == "none":
        return base + omega
    stiffer = p["k1"] / paper_results.TUNED_K1
    return base * (0.2 + 3 * (stiffer - 1) * (system.kind == "ssbl") + (system.kind == "ssul"))


def all_different(system, omega):
    """Return energies that differ from each parameter set to the next."""
    spread = 1 + 40 * (system.parameters.get("C", 0.03) - 0.03) * (system.kind == "ssul")
    return paper_results.published(system, omega) * spread


def unchanging(system, omega):
    """Return energies that no change of the structure or force changes, alike in all dampers."""
    tuned = {"m1": 1000.0, "k1": paper_results.TUNED_K1, "c1": 452.0, "P": 800.0, "omega": 6.28}
    return paper_results.published(System("none", tuned), omega) * {
        "none": 1.0,
        "tmd": 0.42,
        "ssbl": 0.4,
    }.get(system.kind, 0.35)


CONTRARY = {"k1": (4.0, 1.3, 1.2), "c1": (3.0, 2.0, 1.4), "P": (1.4, 2.0, 3.0)}
"""By what the energies of SSul NES, SSbl NES and TMD grow when one parameter changes."""


def contrary(system, omega):
    """Return energies that every change makes higher, and the printed surface highest."""
    p = system.parameters
    base = paper_results.bell(omega, 1500, 6.28) + 10
    if system.kind == "none":
        return base
    tuned = {"k1": paper_results.TUNED_K1, "c1": 452.0, "P": 800.0}
    kind = ("ssul", "ssbl", "tmd").index(system.kind)
    growth = np.prod([f[kind] for key, f in CONTRARY.items() if p[key] != tuned[key]])
    share = (p["C"] - 0.02) * 12 if system.kind == "ssul" else 0.3
    return base * share * growth * (1 - 0.1 * abs(np.log10(p.get("E2", 2.05e7) / 2.05e7)))


RESULTS = {
    "unchanging": paper_results.made_up(unchanging, damper=20, regimes=paper_results.simple),
    "contrary": paper_results.made_up(
        contrary, regimes=paper_results.restless, design=paper_results.better_design, reduction=-0.5
    ),
    "chaos": paper_results.made_up(regimes=paper_results.chaos_around),
    "all_different": paper_results.made_up(all_different),
    "published": paper_results.made_up(),
    "better designs": paper_results.made_up(design=paper_results.better_design),
    "worse designs": paper_results.made_up(design=paper_results.worse_design),
    "restless": paper_results.made_up(regimes=paper_results.restless),
    "other orbits": paper_results.made_up(
        orbits=paper_results.unlike_published, walls=0.0, reduction=-0.5
    ),
    "better": paper_results.made_up(better),
    "rising": paper_results.made_up(rising, damper=0.01, reduction=-0.5),
    "unlike": paper_results.made_up(unlike, damper=0.01),
    "without impacts": paper_results.made_up(regimes=paper_results.without_impacts),
    "without period": paper_results.made_up(regimes=paper_results.without_period),
    "spoiled": paper_results.made_up(regimes=paper_results.without_period, reduction=-0.5),
    "in turns": paper_results.made_up(regimes=paper_results.in_turns),
    "other K": paper_results.made_up(regimes=paper_results.softer_alone),
    "heavy": paper_results.made_up(m2=160.0, k2=1e8),
}
