"""How long chaos lasts before it ends, over an ensemble of starts, and where the starts end.

As a command: `python -m nlds_vines.transients`, or `nlds-vines transients`.
In Python: `nlds_vines.transient_lifetimes(system)`.
"""

from __future__ import annotations

import argparse
import os
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, ClassVar

from nlds_vines.bifurcation import command as bifurcation
from nlds_vines.bifurcation.request import Scan, load_scan
from nlds_vines.bifurcation.result import ScanArchive
from nlds_vines.cli.command import of_task
from nlds_vines.cli.options import SET, SYSTEM, Option
from nlds_vines.errors import RequestError, from_text, number, whole
from nlds_vines.model.parameters import setting_in_words
from nlds_vines.model.setting import Form, settings_of
from nlds_vines.model.system import System
from nlds_vines.runs.run_options import RunOptions
from nlds_vines.scans.run_report import Report
from nlds_vines.transients.ensemble import DELAY, Ensemble, ensemble_of

_NAME = "transients"
_SYSTEM = "ssul-set6"
STARTS, TRANSIENT, PERIODS = 1000, 4000, 120
"""Random starts; forcing periods of each that are discarded, and that are sampled then."""

_SAMPLING = {"transient": TRANSIENT, "periods": PERIODS}

FORM = Form("lifetimes", (Scan,), without=("record", "spectrum"))
"""What is used of a request file: its system, [set] and [sampling]."""

_WANT = ("regime", "settling", "lyapunov", "evidence")
_EXAMPLES = f"""\
examples:
  nlds-vines transients --set omega=7.575 --set K=2.5e7
      SSul NES Set 6, {STARTS} random starts: transients.h5 and transients.png
  nlds-vines transients --set omega=7.575 --set K=2.5e7 --resume --delay 200 --plot late.pdf
      the same archive looked at again, the exponential law fitted beyond 200 periods
  nlds-vines transients --system ssbl --set omega=6.3 --starts 200 --seed 1 -o ssbl.h5
exit status: 0 done; 1 finished, but some orbits failed; 2 the request is wrong;
130 interrupted, 143 terminated: --resume goes on
"""


# public: its keywords are those of the command, more than eight
def transient_lifetimes(
    system: System | str | os.PathLike[str] | None = None,
    *,
    to: str | os.PathLike[str] | None = None,
    starts: int = STARTS,
    seed: int = 0,
    transient: int | None = None,
    periods: int | None = None,
    method: str | None = None,
    effort: str | None = None,
    tolerance: float | str | None = None,
    delay: float = DELAY,
    threads: int | None = None,
    resume: bool = False,
    overwrite: bool = False,
    quiet: bool = False,
) -> Ensemble:
    """Follow many random starts of a system; return how long each took to settle, and where.

    Parameters
    ----------
    system : System, str or path-like, optional
        A system, its name or TOML file; by default SSul NES Set 6.  Of a request file the system,
        [set] and [sampling] are used.
    to : path-like, optional
        The archive (.h5).  Without it the results stay in memory.
    starts, seed : int
        Number of random starts, and the seed that draws them.
    transient, periods : int, optional
        Forcing periods of each orbit, discarded and sampled; by default those of the file, or 4000
        and 120.  An orbit that has not settled then is
        watched for as many more as `effort` allows.
    method, effort : str, optional
        `exact`, the default, or `rk4`; `quick`, `standard`, the default, or `thorough`.
    tolerance : float or str, optional
        Of method exact: a number, `draft`, `standard` (the default) or `fine`.
    delay : float
        Forcing periods after which lifetimes count in the exponential law.
    threads : int, optional
        By default one for each processor.
    resume, overwrite : bool
        Continue or replace an existing archive; not both.
    quiet : bool
        Hide the progress bar.

    Returns
    -------
    Ensemble
        Lifetimes, labels and shares of the final regimes.

    Raises
    ------
    RequestError
        If anything in the request is wrong, before anything is computed.

    Examples
    --------
    >>> import nlds_vines as nv
    >>> system = nv.load_system("ssul-set6", omega=7.575)
    >>> ensemble = nv.transient_lifetimes(system, starts=20, transient=200, quiet=True)
    >>> ensemble.labels.size, sum(share.count for share in ensemble.shares)
    (20, 20)
    """
    given = {
        "transient": transient,
        "periods": periods,
        "method": method,
        "effort": effort,
        "tolerance": tolerance,
    }
    sampling = {key: value for key, value in given.items() if value is not None}
    changes = {"start": {"count": starts, "seed": seed}, "sampling": sampling}
    scan = _load(system, changes, "transient_lifetimes")
    archive = ScanArchive.for_result(to, _NAME, resume, overwrite)
    how = RunOptions(threads, resume, overwrite, quiet=quiet)
    Job.compute(scan, system, archive, how, delay=delay)
    return ensemble_of(archive, delay=delay)


@dataclass(frozen=True)
class Job(bifurcation.Job):
    """The scan of an ensemble and its files; lifetimes beyond `delay` count in the law."""

    default: ClassVar[str] = f"{_NAME}.h5"

    delay: float = DELAY

    def __post_init__(self) -> None:
        super().__post_init__()
        delay: Any = self.delay
        if isinstance(delay, str):
            delay = from_text(float, "--delay", delay)
        object.__setattr__(self, "delay", number("delay", delay))
        if self.delay < 0.0:
            raise RequestError(f"delay = {self.delay!r} must not be negative")

    @classmethod
    def from_options(cls, request: Scan, options: argparse.Namespace) -> Job:
        job = super().from_options(request, options)
        assert isinstance(job, Job)
        return job if job.plot else replace(job, plot=job.archive.with_suffix(".png"))

    @classmethod
    def read(cls, path: Path) -> Ensemble:
        return ensemble_of(path)

    @classmethod
    def picture(cls) -> Any:
        from nlds_vines.transients.picture import PICTURE

        return PICTURE

    def draw(self, plot: Path, results: Report) -> None:
        from nlds_vines.transients.picture import picture

        picture(self.delay).save(self.archive, plot, frequency=self.frequency, look=self.look)

    def lines(self, results: Report) -> list[str]:
        ensemble = ensemble_of(self.archive, delay=self.delay)
        return [self.request.title, *ensemble.lines(), *results.inadmissible()]


def _load(source: Any, changes: dict[str, Any], changes_from: str) -> Scan:
    """Return the scan of one cell that computes an ensemble of a system."""
    named = changes.pop("system", None) or (_SYSTEM if source is None else source)
    used: dict[str, Any] = {key: changes.pop(key) for key in ("set", "sampling") if key in changes}
    document = FORM.read(named, used, changes_from)
    system: System = document.as_set(document.any_system())
    start = {"policy": "random", "count": STARTS} | changes.pop("start", {})
    count = whole("count", start["count"], 1)
    shown = {**system.drive, **system.contact_in_words}
    words = [system.in_words(), *(setting_in_words(*item) for item in shown.items())]
    scan = {
        "title": f"{', '.join(words)}: {count} starts",
        "system": system,
        "vary": {"omega": {"values": [system.parameters["omega"]]}},
        "sampling": {**_SAMPLING, **document.document.get("sampling", {})},
        "record": {"want": list(_WANT)},
    }
    request = load_scan(scan, {**changes, "start": start}, changes_from)
    document.tell_left()
    return request


def _whole(flag: str, words: str, key: str) -> Option:
    return Option(flag, "N", words, lambda text: {"start": {key: from_text(int, flag, text)}})


main = of_task(
    _NAME,
    _load,
    Job,
    ("SYSTEM.toml", f"a system, or --system [{_SYSTEM}]"),
    (
        SYSTEM,
        SET,
        _whole("--starts", f"random ones [{STARTS}]", "count"),
        _whole("--seed", "that they are drawn by [0]", "seed"),
        Option("--delay", "PERIODS", f"before the law [{DELAY:g}]"),
    ),
    (Scan,),
    but=[item.key for item in settings_of(Scan).values() if item.table != "sampling"],
    usual=_SAMPLING,
    description="How long chaos lasts over an ensemble of starts, and where they end.",
    examples=_EXAMPLES,
    common="--output --plot --system --set --starts --seed --transient --delay",
).main
