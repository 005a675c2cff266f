"""The report: every claim with its verdict, what tunings retain, what the paper leaves open."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from nlds_vines.archives.files import write_text
from nlds_vines.archives.provenance import version
from nlds_vines.cli.terminal import table
from nlds_vines.model.catalog import catalog
from nlds_vines.model.parameters import PARAMETERS
from paper.claims import (
    CLAIMS,
    FACTS,
    Claim,
    Evidence,
    Missing,
    Verdict,
    archived,
    judge,
)
from paper.claims.claim import tuning_frequency
from paper.claims.contact_constants import SPECIAL
from paper.claims.free_movement import best_within, taken_by_set_6
from paper.claims.measured import Follow, Motion, not_followed
from paper.claims.parameter_sets import SET6, SETS
from paper.claims.retention import Retained, retained
from paper.claims.three_dampers import FREED
from paper.request import FigureRequest, packaged_figures

RETENTION = (("4", "k1"), ("6", "c1"), ("7", "P"))
"""The figures on which one parameter changes, by short name, and that parameter."""

_CURVES_OF_DAMPERS = (
    ("3", "none"),
    ("3", "tmd"),
    ("3", "ssbl"),
    *(("2a", name) for name in SETS),
    ("rounding", "ssul-set6-table2"),
    ("free-tmd", FREED),
)

_NOT_PRINTED = (
    "Contact: A, B and q1 of equation (4). K follows from them, and the frequencies of the narrow "
    "regimes follow K; the table of contact stiffness shows how.",
    "Figures 4 and 5: the values of k1. Those here are ours.",
    "Tables 1 and 2: the bounds of the optimizations. Two of the claims compare the TMD of Table 2 "
    "with one that is tuned without them.",
    "All figures: the frequencies at which they were computed, how much of the transient was left "
    "out, and whether an orbit begins at rest or on its neighbor's attractor. Here every orbit "
    "begins at rest, the energies are those of the steady state, and the grids stand in the "
    "request files.",
    "Equation (1) reads as if it bounded the motion; here it is the condition of contact, as "
    "equations (3) and (5) have it.",
)


def write(path: Path, archives: Path, picture: str, follow: Follow = not_followed) -> None:
    """Write the report in Markdown to `path`; nothing is computed but closed forms and few orbits.

    Arguments: the path; `archives`, the folder of the archives; `picture`, the suffix of the
    pictures, which lie beside the report; `follow` returns the motions of a portrait, and is asked
    for those whose picture is there.

    Raises `RequestError` where the report cannot be written or an archive cannot be read.
    """
    requests = packaged_figures()

    def drawn(request: FigureRequest) -> Sequence[Motion]:
        there = (path.parent / f"{request.name}.{picture}").exists()
        return (follow if there else not_followed)(request)

    evidence = archived(requests, archives, drawn)
    text = "\n".join(_Report(requests, evidence, path.parent, picture).lines())
    write_text(path, f"{text}\n")


@dataclass(frozen=True)
class _Report:
    """The report: all requests by short name, the evidence, its folder, the pictures' suffix."""

    requests: Mapping[str, FigureRequest]
    evidence: Evidence
    folder: Path
    picture: str

    def lines(self) -> Iterator[str]:
        """Yield the report, a line at a time."""
        yield "# The paper, claim by claim"
        yield ""
        yield (
            f"Made by `python -m paper`, nlds_vines {version('nlds-vines')}; not written by "
            "hand. The claims are the paper's in our words. Every number comes from an archive "
            "in the folder beside this report, from the orbit of a figure, or from a closed form "
            "where that is said. A claim agrees in part where one measure of it holds and another "
            "does not, where it holds for some of the dampers, or only with another contact "
            "stiffness than the assumed one; the text says which."
        )
        yield ""
        yield from self._claims()
        yield from self._dampers()
        yield from self._retention()
        yield from self._stiffness()
        yield from self._free_movement()
        yield from _heading("What the paper does not say")
        yield from (f"- {text}" for text in _NOT_PRINTED)
        yield from self._figures()

    def _claims(self) -> Iterator[str]:
        """Yield the tables of claims and of checks against closed forms, with their verdicts."""
        found = [(claim, judge(claim, self.evidence)) for claim in CLAIMS]
        count = Counter(finding.verdict for _, finding in found)
        total = ", ".join(f"{count[v]} {v}" for v in Verdict if count[v])
        yield f"Of {len(found)} claims: {total}."
        yield ""
        head = ("where", "claim", "what comes out", "verdict", "see")
        rows = (
            (c.where, _with_rule(c), f.text, f"**{f.verdict}**", self._see(c)) for c, f in found
        )
        yield from table(head, rows)
        yield from _heading("The program against closed forms")
        facts = ((claim, judge(claim, self.evidence)) for claim in FACTS)
        checks = ((c.statement, f.text, f"**{f.verdict}**", self._see(c)) for c, f in facts)
        yield from table(("check", "what comes out", "verdict", "see"), checks)

    def _see(self, claim: Claim) -> str:
        """Return a link to the picture of a claim."""
        request = self.requests[claim.figure]
        number = request.name.removeprefix("figure")
        text = number if number == request.name else f"Figure {number}"
        return f"[{text.removeprefix('study-')}]({request.name}.{self.picture})"

    def _dampers(self) -> Iterator[str]:
        """Yield the table of the dampers and what each achieves."""
        yield from _heading("The dampers")
        tuned = tuning_frequency()
        yield "Steady state from rest; the reduction is that of the peak without a damper."
        yield ""
        head = (
            "damper",
            f"E1max at {tuned:g} rad/s [J]",
            "peak [J]",
            "at [rad/s]",
            "reduction",
            "E2max [J]",
        )
        yield from table(head, filter(None, (self._damper(*curve) for curve in _CURVES_OF_DAMPERS)))

    def _damper(self, figure: str, name: str) -> tuple[str, ...] | None:
        """Return a row of the table of dampers; None for one that has not been computed."""
        try:
            data, bare = self.evidence(figure, name), self.evidence("3", "none")
        except Missing:
            return None
        peak, omega = data.peak()
        title = data.system.title if name == data.system.name else f"{data.system.title}, {name}"
        damper = data.system.scene.damper
        return (
            title,
            f"{data.at(tuning_frequency()):.2f}",
            f"{peak:.1f}",
            f"{omega:.3f}",
            f"{100 * (1 - peak / bare.peak()[0]):.0f} %",
            f"{data.peak('E2max')[0]:.1f}" if damper else "-",
        )

    def _retention(self) -> Iterator[str]:
        """Yield the tables of what remains of the tuning when a parameter changes."""
        yield from _heading("Retention of tuning")
        yield (
            "Each damper keeps its values while one number of structure or force changes. "
            "`ratio`: over the same quantity at the tuning (bold); `left`: the peak over that of "
            "the structure alone at the same value."
        )
        for short, parameter in RETENTION:
            yield ""
            yield from self._retention_table(short, parameter)

    def _retention_table(self, short: str, parameter: str) -> Iterator[str]:
        """Yield the table of one changed parameter, from the figure of that short name."""
        try:
            rows = retained(self.requests[short], parameter, self.evidence, short)
        except Missing as missing:
            yield f"{parameter}: {missing}."
            return
        head = ("damper", f"{parameter} [{PARAMETERS[parameter].unit}]", "peak [J]", "at [rad/s]")
        tuned = f"E1max at {tuning_frequency():g} rad/s [J]"
        yield from table((*head, "ratio", tuned, "ratio", "left"), map(_retention_cells, rows))

    def _stiffness(self) -> Iterator[str]:
        """Yield the table of the labels at the special frequencies by contact stiffness."""
        yield from _heading("Contact stiffness and the special regimes")
        try:
            study = self.evidence("stiffness", SET6)
        except Missing as missing:
            yield f"{missing}."
            return
        yield (
            "Labels from rest, SSul NES Set 6; published: 3T,3, chaos, transient chaos to T,0. "
            f"The assumed constants give K = {study.system.K:.6g} N/m^1.5."
        )
        yield ""
        labels = [study["label"][study.place(omega)] for omega in SPECIAL]
        rows = (
            (f"{k:.3g}", *map(str, row)) for k, *row in zip(study.axes["K"], *labels, strict=True)
        )
        yield from table(("K [N/m^1.5]", *(f"{omega:.3f} rad/s" for omega in SPECIAL)), rows)

    def _free_movement(self) -> Iterator[str]:
        """Yield the tables of what the free movement behind a damper is worth (Figure 1c)."""
        yield from _heading("The design that the paper leaves open (Figure 1c)")
        try:
            best, taken = list(best_within(self.evidence)), list(taken_by_set_6(self.evidence))
        except Missing as missing:
            yield f"{missing}."
            return
        yield (
            "A damper that may pass the structure by L. First the least energy of all dampers that "
            f"keep L, at {tuning_frequency():g} rad/s; then how far Set 6 passes the structure "
            "where k1 changes: with as much L its tuning is kept as that of Figure 1d. "
            "Transients from rest count."
        )
        yield ""
        damper = ("L [m]", "least E1max [J]", "k2 [N/m]", "c2 [N s/m]", "dampers that keep L")
        yield from table(damper, best)
        yield ""
        way = ("k1 [N/m]", "peak [J]", "at [rad/s]", "L where tuned [m]", "at the peak", "at most")
        yield from table(way, taken)

    def _figures(self) -> Iterator[str]:
        """Yield the pictures beside the report; a link where Markdown cannot show them."""
        yield "\n## Figures"
        for request in self.requests.values():
            name = f"{request.name}.{self.picture}"
            if (self.folder / name).exists():
                yield ""
                yield f"{'' if self.picture == 'pdf' else '!'}[{request.title}]({name})"


def _heading(text: str) -> Sequence[str]:
    """Return the lines of a heading."""
    return "", f"## {text}", ""


def _with_rule(claim: Claim) -> str:
    """Return a claim, and its rule if it has one."""
    return f"{claim.statement} *({claim.rule})*" if claim.rule else claim.statement


def _retention_cells(row: Retained) -> tuple[str, ...]:
    """Return the cells of a row of the table of retention."""
    damper = catalog()[row.damper]
    return (
        damper.title,
        _marked(row.value, damper.parameters[row.parameter]),
        f"{row.peak:.1f}",
        f"{row.omega:.3f}",
        f"{row.relative:.2f}",
        f"{row.tuned:.1f}",
        f"{row.relative_tuned:.2f}",
        f"{row.left:.2f}",
    )


def _marked(value: float, base: float) -> str:
    """Return a value in words, bold where it is that of the tuning."""
    return f"**{value:g}**" if value == base else f"{value:g}"
