"""The same damper under each contact law: the page docs/contact-laws.md, measured.

    python -m benchmarks.contact_laws            print the page
    python -m benchmarks.contact_laws -o FILE    write it

The cost is the CPU time of orbits from random starts over that under Hertz' law, the two timed in
turn, the median of several rounds.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator, Mapping
from pathlib import Path
from statistics import median
from typing import Any

import numpy as np

from benchmarks.cases import orbits, spent
from nlds_vines.archives.files import write_text
from nlds_vines.cli.terminal import table
from nlds_vines.engine.classification import classify
from nlds_vines.engine.simulation import simulate
from nlds_vines.model.catalog import load_system
from nlds_vines.model.system import Preset

HERTZ = load_system("ssul-set6")
SOFT = 1e6  # N/m: an impact at 1 m/s under the linear law is then about as long as Hertz' here
SETTLED, TIMED, ROUNDS = 400, 1000, 7
CHANGES: Mapping[str, Mapping[str, Any]] = {
    "hertz": {},
    "hertz, hunt_crossley = 0.2 s/m": {"hunt_crossley": 0.2},
    "power, n = 1.5, the same K": {"law": "power", "K": HERTZ.K, "exponent": 1.5},
    "power, n = 1.2, K = 6e6": {"law": "power", "K": 6e6, "exponent": 1.2},
    "power, n = 2, K = 5e8": {"law": "power", "K": 5e8, "exponent": 2.0},
    "linear, kc = 1e6": {"law": "linear", "kc": SOFT},
    "linear, kc = 1e6, cc = 1000": {"law": "linear", "kc": SOFT, "cc": 1000.0},
    "kelvin-voigt, kc = 1e6, cc = 1000": {"law": "kelvin-voigt", "kc": SOFT, "cc": 1000.0},
    "restitution, e = 1": {"law": "restitution", "e": 1.0},
    "restitution, e = 0.7": {"law": "restitution", "e": 0.7},
    "restitution, e = 0": {"law": "restitution", "e": 0.0},
}
STIFFER = (1e7, 1e9, 1e11, 1e13, 1e15)
EXPONENTS = (1.5, 1.2, 1.1, 1.01, 1.001, 1.0)


HEADS = (
    "law",
    "regime",
    "E1max",
    "E2max",
    "gain of E2 in an impact",
    "lost in contacts, a period",
    "longest contact",
    "greatest force",
    "cost",
)


def behavior(system: Preset) -> tuple[str, ...]:
    """Return the columns of `HEADS` from the regime to the greatest force, once settled."""
    regime = classify(system)
    run = simulate(
        system, regime.period or 60, start=tuple(simulate(system, SETTLED).state),
        record=("section", "impacts", "energy"),
    )  # fmt: skip
    assert run.impacts is not None
    assert run.E1max is not None
    assert run.E2max is not None
    whole = run.impacts[~np.isnan(run.impacts["release"])]
    lost = -np.sum(whole["gain1"] + whole["gain2"]) / (regime.period or 60)
    lasting, force = np.max(whole["release"] - whole["touch"]), np.max(whole["force"])
    return (
        regime.label, f"{run.E1max:.1f} J", f"{run.E2max:.1f} J",
        f"{np.mean(whole['gain2']):.2f} J", f"{lost:.2f} J", f"{1e3 * lasting:.1f} ms",
        "no bound" if np.isinf(force) else f"{force:.0f} N",
    )  # fmt: skip


def cost(system: Preset, other: Preset) -> float:
    """Return the CPU time of a period of one system over that of another."""
    mine, theirs = orbits(system, TIMED), orbits(other, TIMED)
    return median(spent(mine) / spent(theirs) for _ in range(ROUNDS))


def apart(system: Preset, other: Preset) -> float:
    """Return how far the settled sections of two systems are apart, relative to their size."""
    one, two = (simulate(s, SETTLED, tolerance=1e-12).state for s in (system, other))
    return float(np.max(np.abs(one - two)) / np.max(np.abs(two)))


def page() -> Iterator[str]:
    yield from INTRODUCTION.splitlines()
    rows = []
    for name, change in CHANGES.items():
        system = HERTZ.with_(**change)
        rows.append((name, *behavior(system), f"{cost(system, HERTZ):.2f}"))
    yield from table(HEADS, rows, right=range(2, len(HEADS)))
    yield from LIMITS.splitlines()
    rigid = HERTZ.with_(law="restitution", e=1.0)
    far = [apart(HERTZ.with_(K=K), rigid) for K in STIFFER]
    order = np.polyfit(np.log(STIFFER[2:]), np.log(far[2:]), 1)[0]
    stiff = zip(STIFFER, far, strict=True)
    yield from table(("K", "distance"), [(f"{K:.0e}", f"{d:.1e}") for K, d in stiff], right=(0, 1))
    yield ""
    yield (
        f"The last three distances are proportional to K^{order:.3f}, and so is the duration of a "
        "contact (K^-0.4)."
    )
    yield from POWERS.splitlines()
    spring = HERTZ.with_(law="linear", kc=SOFT)
    powers = [
        (f"{n:g}", f"{apart(HERTZ.with_(law='power', K=SOFT, exponent=n), spring):.1e}")
        for n in EXPONENTS
    ]
    yield from table(("n", "distance"), powers, right=(0, 1))


INTRODUCTION = """\
# Which contact law?

This page is made by a command, in a clone:
`python -m benchmarks.contact_laws -o docs/contact-laws.md`.

A law says what a wall does to the damper that meets it.
[Parameters](dampers.md#contact-laws) lists them with their constants. Choose

- `hertz` where the bodies are elastic and their materials known: the law of the paper.
  `hunt_crossley` adds damping.
- `restitution` where a coefficient was measured, and where nobody asks for forces or for how long
  a contact lasts. It is the cheapest, and what most papers on VI NES use.
- `linear` for soft stops, rubber, or a spring that was built: kc and cc can be measured.
  `kelvin-voigt` is the same with a joint that may pull until the depth is zero; in nature only
  glue does. Both are exact, and their round-off has no bias: without damping and
  forcing, energy is kept to 5e-10 for 100,000 periods.
- `power` where a force was measured over the depth.

The table shows SSul NES Set 6 at 6.28 rad/s under each law, from rest, once it has settled. Gains
and losses are measured from touch to release, including the work of all other forces meanwhile.
Costs are CPU times of orbits from random starts over 100 periods, in units of that under `hertz`,
timed in turn (to some per cent). Contacts under `power` or with `hunt_crossley` are stepped, which
costs most.

"""

LIMITS = """
With e = 1 impacts conserve energy, as under `hertz`, but take no time. The stiffer the contact, the
closer the two laws. The distance is that of the settled sections, the largest
difference of their four numbers relative to the largest of them.

"""

POWERS = """
The power law goes over into `linear` with kc = K = 1e6 as n goes to 1:

"""


def main() -> None:
    parser = argparse.ArgumentParser(description="The same damper under each contact law.")
    parser.add_argument("-o", metavar="FILE", type=Path, help="write the page to a file")
    options = parser.parse_args()
    text = "\n".join(page()) + "\n"
    if options.o is None:
        print(text)
    else:
        write_text(options.o, text)


if __name__ == "__main__":
    main()
