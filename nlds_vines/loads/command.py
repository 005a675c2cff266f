"""The command `nlds-vines response-history` and the function `nlds_vines.response_history`."""

from __future__ import annotations

import os
import re
from collections.abc import Sequence
from concurrent.futures import Executor
from contextlib import suppress
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar

from nlds_vines.cli import command as commands
from nlds_vines.cli.options import SAMPLES, SET, VARY, Option, assignments
from nlds_vines.cli.running import add_run_options
from nlds_vines.errors import RequestError, at, from_text, table, unknown
from nlds_vines.loads.datasets import blocks_of
from nlds_vines.loads.request import (
    Beside,
    HistoryRequest,
    Source,
    load_response_history,
    load_table,
)
from nlds_vines.model.axis import samples_of
from nlds_vines.model.catalog import any_system
from nlds_vines.model.loads.loading import ALL, Loading
from nlds_vines.runs.run_options import RunOptions
from nlds_vines.scans.run_report import Report
from nlds_vines.scans.scan_job import ScanJob

if TYPE_CHECKING:
    from nlds_vines.loads.result import LoadScan, ResponseHistories

TEXTS = ("file", "decimal")  # keys whose values are texts, even if they look like numbers

_NAME = "response-history"
_EXAMPLES = """\
examples:
  nlds-vines response-history --impulse 1000 --duration 20 --plot history.png
      the paper's structure alone and with its dampers, struck to 1 m/s
  nlds-vines response-history --impulse 300 --system tmd --system ssul-set6 --set c1=100 -o soft.h5
      a softer blow, two dampers, a structure with less damping of its own
  nlds-vines response-history --load friedlander:peak=2e4,length=0.1 --duration 20 --plot blast.png
      the pulse of a blast; half_sine, triangular, rectangular, tone, sweep, noise likewise
  nlds-vines response-history --load quake.csv --duration 40 -o quake.h5
      a record: a table of times and values, PEER, COSMOS, SMC; or with what the file does not say
  nlds-vines response-history --load a.AT2 --load b.AT2 --scale-to Sa=0.5g,T=0.8 \\
                   --duration 40 -o suite.h5
      a suite: each record by itself, scaled alike; medians and 84 % quantiles
  nlds-vines response-history --load record:file=./quake.txt,dt=0.01,unit=g --duration 40 -o q.h5
  nlds-vines response-history --system ssul-set6 --vary impulse=100:2000:60 --vary C=0:0.2:40 \\
                   --duration 20 -o blows.h5 --plot blows.png
      a map: the blow against the clearance
exit status: 0 done; 1 finished, but some orbits failed; 2 the request is wrong;
130 interrupted, 143 terminated: --resume goes on
"""


def response_history(
    source: Source = None,
    *,
    impulse: float | None = None,
    duration: float | None = None,
    to: str | os.PathLike[str] | None = None,
    threads: int | None = None,
    resume: bool = False,
    overwrite: bool = False,
    scheduler: str | None = None,
    executor: Executor | None = None,
    quiet: bool = False,
    **tables: Any,
) -> ResponseHistories | LoadScan:
    """Compute the responses of systems to a load.

    Parameters
    ----------
    source : optional
        A system or its name, a list of these, the path of a request file, the document in one, a
        `HistoryRequest`, or None for the paper's structure alone and with its dampers.
    impulse : float, optional
        Impulse on m1 at t = 0 [N s].
    duration : float, optional
        Length of the histories [s], 60 by default.
    to : path-like, optional
        Archive to write (.h5).
    threads : int, optional
        By default one for each processor.
    resume, overwrite : bool, optional
        Continue or replace an archive that exists.
    scheduler, executor : optional
        Who computes blocks of orbits, as in `scan`.
    quiet : bool, optional
        Show no progress.
    **tables
        Tables of a request file, which override the source: `load`, a table, the path of a
        record, or a suite, a list of paths or a folder; `set={"c1": 100.0}`;
        `start={"state": (0.1, 0.0, 0.0, 0.0)}`; `sampling`; `vary` makes a scan. For a host, `of`
        names the displacements to report, such as "roof", a damper's mass "cell" or "roof-floor2";
        `heights=3.5` are those of its storeys [m], for drift ratios. `beside=["alone", "tmd"]`
        compares with the structure alone and with a tuned mass damper of the same mass.
        `samples` (arrays, a DataFrame or a CSV file, in each row one set of parameters or numbers
        of the load) makes a scan over the dimension `sample`.

    Returns
    -------
    ResponseHistories or LoadScan
        Histories and quantities of each system; with `vary` or a suite the quantities over its
        axes and records.

    Raises
    ------
    RequestError
        If the request is wrong, before anything is computed.

    Notes
    -----
    The structure is at rest at t = 0 unless `start` has a state.  The harmonic force acts only if
    `load={"harmonic": True}`.

    Examples
    --------
    >>> import nlds_vines as nv
    >>> histories = nv.response_history("tmd", impulse=300.0, duration=10.0, quiet=True)
    >>> [round(time, 2) for time in histories.times.values()]
    [6.55, 3.37, 1.0]
    """
    if tables.get("load") is not None:
        tables["load"] = load_table(tables["load"])
    if tables.get("samples") is not None:
        tables["samples"] = samples_of(tables["samples"]).columns
    above = dict(tables)
    for name in ("of", "beside", "heights"):
        value = above.pop(name, None)
        if value is None:
            continue
        is_text = isinstance(value, str)
        record = table("record", above.get("record", {}))
        above["record"] = {**record, name: [value] if is_text else value}
    for key, name, number in (("load", "impulse", impulse), ("sampling", "duration", duration)):
        if number is not None:
            above[key] = {**table(key, above.get(key, {})), name: number}
    request = load_response_history(source, above, _NAME)
    how = RunOptions(threads, resume, overwrite, None, scheduler, quiet, executor)
    result: ResponseHistories | LoadScan = Job.compute(request, source, to, how)
    return result


class Job(ScanJob):
    default: ClassVar[str] = f"{_NAME}.h5"
    is_named_after_source: ClassVar[bool] = True

    request: HistoryRequest

    def compute_archive(self) -> Any:
        from nlds_vines.loads.run import run

        return run(self.request, self.archive, self.how)

    @classmethod
    def read(cls, path: Path) -> Any:
        from nlds_vines.loads.result import histories_in

        return histories_in(path)

    @classmethod
    def picture(cls) -> Any:
        from nlds_vines.loads.picture import PICTURE

        return PICTURE

    def failure(self, results: Any) -> str:
        if isinstance(results, Report):
            return super().failure(results)
        return f"{results.failed} of {self.request.cases} orbits failed" if results.failed else ""

    def plan(self) -> list[str]:
        request = self.request
        varied = [f"axis:     {axis.heading()}" for axis in request.vary]
        if request.sampled is not None:
            varied = [f"sampled:  {line}" for line in request.sampled.ranges()]
        return [
            request.title,
            *(f"system:   {words}" for words in request.words),
            f"load:     {request.load.words() or 'none'}",
            *(f"          {line}" for line in request.load.records_in_words(request.duration)),
            *varied,
            f"followed: {request.duration:g} s, {request.times.size - 1} states each; "
            f"{request.cases} orbits",
            *self.share(blocks_of(request)),
            f"archive:  {self.archive}",
            *([] if self.plot is None else [f"picture:  {self.plot}"]),
        ]


def _loads(texts: Sequence[str]) -> dict[str, Any]:
    """Return the table of loads, each KIND:KEY=VALUE,... or the path of a record.

    Several paths, and a folder, are a suite.
    """
    load: dict[str, list[dict[str, Any]]] = {}
    paths: list[str] = []
    for text in texts:
        kind, colon, rest = text.partition(":")
        if not colon or kind not in ALL:
            if colon and kind.isidentifier() and not os.path.exists(text):
                raise unknown("load", kind, ALL)
            paths.append(text)
            continue
        entry: dict[str, Any] = {}
        pairs = re.split(r",(?=\w+=)", rest)  # a path may contain commas
        for key, value in assignments(f"--load {kind}:", pairs, "KEY=VALUE").items():
            entry[key] = (value == "true") if value in ("true", "false") else value
            if isinstance(entry[key], str) and key not in TEXTS:
                is_whole = value.isascii() and value.isdigit()
                with suppress(RequestError):  # the key's check refuses other texts
                    entry[key] = from_text(int if is_whole else float, "", value)
        load.setdefault(kind, []).append(entry)
    files = [{"file": path} for path in paths]
    if len(paths) > 1 or any(map(os.path.isdir, paths)):
        load["suite"] = files
    elif files:
        load["record"] = [*files, *load.get("record", [])]
    return {"load": load}


LOAD = Option(
    "--load", "LOAD",
    "a record (CSV, AT2 ..., HDF5), or several or a folder of them: a suite; or "
    "KIND:KEY=VALUE,..., once for each of a sum", _loads, True,
)  # fmt: skip


def _systems(names: list[str]) -> dict[str, Any]:
    with at("--system"):
        return {"systems": [any_system(name, needs_force=False) for name in names]}


SYSTEMS = Option(
    "--system", "NAME", "a system: of the catalog, or a TOML file; once for each", _systems, True
)
SOURCE = "a request file, or a system [the paper's structure alone and with its dampers]"
main = commands.of_task(
    _NAME,
    load_response_history,
    Job,
    ("HISTORY.toml", SOURCE),
    (SYSTEMS, SET, VARY, SAMPLES, LOAD),
    (Loading, HistoryRequest, Beside),
    add_run=partial(add_run_options, cluster=True),
    description="Loads in time: how a structure's energy falls with each damper, where it goes.",
    examples=_EXAMPLES,
    common="--output --plot --system --set --vary --load --impulse --duration",
).main
