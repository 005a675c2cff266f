"""A finished archive opened or drawn: `nlds-vines plot FILE.h5`, `nv.plot`, `nv.open_archive`."""

from __future__ import annotations

import argparse
import os
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from nlds_vines.archives.archive import ArchivePath, ArchiveView, read
from nlds_vines.archives.provenance import RESPONSE_HISTORY, SCAN
from nlds_vines.cli.command import Command, Job
from nlds_vines.cli.options import FREQUENCY, LOOK, Parser, look_of
from nlds_vines.cli.running import check_plot, existing, refuse_replacing, refuse_same
from nlds_vines.cli.terminal import DONE, say
from nlds_vines.errors import RequestError, shown
from nlds_vines.model.look import Look
from nlds_vines.upkeep.tasks import JOBS, job_for

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from nlds_vines.bifurcation.response_curves import ResponseCurves
    from nlds_vines.bifurcation.result import ScanArchive
    from nlds_vines.continuation.result import Continued
    from nlds_vines.loads.result import ResponseHistories
    from nlds_vines.plotting.chosen_panels import Drawing
    from nlds_vines.portrait.result import Portrait
    from nlds_vines.transients.ensemble import Ensemble
    from nlds_vines.tuning.result import Tuned

    Opened = (
        ScanArchive
        | Ensemble
        | ResponseCurves
        | Tuned
        | Continued
        | ResponseHistories
        | Portrait
        | ArchivePath
    )

_EXAMPLES = """\
examples:
  nlds-vines plot figure8.h5
      the usual picture of an archive, as figure8.png
  nlds-vines plot figure8.h5 --show v2,E1max -o speeds.pdf
      of a diagram: any recorded quantity, from the top; --show ? names them
  nlds-vines plot regimes.h5 --show settling -o settling.png
      of a map: regimes, coexisting, shares, share:LABEL or a recorded number
  nlds-vines plot figure8.h5 --frequency Hz -o hertz.png
      over f in Hz; `ratio` counts in the frequency of the structure
  nlds-vines plot figure8.h5 --columns 1 --style grayscale -o narrow.pdf
      for one column of a paper, in a style sheet of matplotlib's
exit status: 0 done; 2 the request is wrong
"""


def open_archive(path: str | os.PathLike[str]) -> Opened:
    """Return the results in an archive, as the function that computed them returned them.

    Parameters
    ----------
    path : str or os.PathLike
        The archive (.h5).

    Returns
    -------
    ScanArchive, Ensemble, ResponseCurves, Tuned, Continued, ResponseHistories or Portrait
        The results, with `.request`, `.plot()`, `.to_xarray()` and `.to_dataframe()`.

    Raises
    ------
    RequestError
        If the file is no archive of this program, or is damaged.

    See Also
    --------
    read : The datasets of any archive by name.

    Examples
    --------
    >>> import nlds_vines as nv
    >>> vary = {"omega": {"values": [6.0, 6.4]}}
    >>> scan = nv.scan("ssul-set6", vary=vary, sampling={"transient": 100}, quiet=True)
    >>> nv.open_archive(scan).request.axes[0].name
    'omega'
    """
    with read(path) as view:
        job = job_for(view)
        return job.read(view.path) if job else ArchivePath.of(view.path)


def panels(archive: str | os.PathLike[str]) -> dict[str, str]:
    """Return the names and the meanings of all that the picture of an archive can show.

    Parameters
    ----------
    archive : str or os.PathLike
        A finished archive.

    Returns
    -------
    dict of str to str
        Each name that `plot` takes as `show`, with its meaning.

    Raises
    ------
    RequestError
        If the file is no archive of this program, or has no picture.

    See Also
    --------
    plot : The picture itself.

    Examples
    --------
    >>> import nlds_vines as nv
    >>> scan = nv.scan("tmd", vary={"omega": [6.0, 6.5]}, record=["energy"], quiet=True)
    >>> list(nv.panels(scan))[:2]
    ['E1max', 'E2max']
    """
    from nlds_vines.plotting.chosen_panels import drawn

    with read(archive) as view:
        job = _drawn_by(view)
        meanings = dict(drawn(view, job.picture().names))
        if view.content == SCAN:  # of an ensemble, those of a scan as well
            meanings |= drawn(view, JOBS[SCAN].picture().names)
        return meanings


def _drawn_by(view: ArchiveView) -> type[Job]:
    """Return the job that draws an archive; `RequestError` if none does."""
    job = job_for(view)
    if job is None:
        raise RequestError(f"{view.path} holds a {view.content}, which has no picture")
    return job


def plot(
    archive: str | os.PathLike[str],
    show: str | None = None,
    ax: Axes | None = None,
    *,
    to: str | os.PathLike[str] | None = None,
    columns: int | str = 2,
    width: float | None = None,
    title: str | None = None,
    style: str | None = None,
    marks: str | os.PathLike[str] | Sequence[str | os.PathLike[str]] = (),
    manifold: bool = False,
    frequency: str | None = None,
) -> Figure:
    """Return the picture of an archive as a matplotlib figure; nothing is computed.

    Parameters
    ----------
    archive : str or os.PathLike
        A finished archive: a scan, transients, a tuning, branches, response histories, a portrait.
    show : str, optional
        Panels, separated by commas, as `nlds-vines plot FILE.h5 --show ?` names them: of a diagram
        quantities such as ``"x2,v2,E1max"``, of a map ``"regimes"`` or a number.  By default the
        usual ones.
    ax : matplotlib.axes.Axes, optional
        Axes to draw one panel into: the one to `show`, or else the first.
    to : str or os.PathLike, optional
        A file (.png, .pdf or .svg) to write as well, in place of an older one: equal archives give
        equal bytes.
    columns : int or str
        1 for a picture as wide as a column of a paper (8.4 cm), 2 for 16 cm.
    width : float, optional
        Another width [cm], with the look of `columns`.
    title : str, optional
        The title, an empty one for none; by default that of the request.
    style : str, optional
        A style sheet of matplotlib's, by name or path.  The user's `matplotlib.rcParams` stay.
    marks : str, os.PathLike or sequence of them
        Continuations of the same system along omega, whose branches are drawn over the energies of
        a sweep (``show="sweep_energy"``).
    manifold : bool
        Whether the bounds of 1:1 motion in closed form (`slow_manifold`) are drawn over a map of
        omega and another parameter.
    frequency : {'rad/s', 'Hz', 'ratio'}, optional
        The unit of the frequency axis: omega, f, or omega over sqrt(k1 / m1).  By default the
        one in which the request states the frequency, rad/s or Hz.

    Returns
    -------
    matplotlib.figure.Figure
        The picture; with `ax`, the figure of these axes.

    Raises
    ------
    RequestError
        For a file that is no archive, and for panels that it has not.

    See Also
    --------
    panels : The names of all panels of an archive.

    Examples
    --------
    >>> import nlds_vines as nv
    >>> vary = {"omega": {"values": [6.0, 6.2, 6.4]}}
    >>> scan = nv.scan("ssul-set6", vary=vary, sampling={"transient": 100}, quiet=True)
    >>> nv.plot(scan, "E1max").savefig("E1max.pdf")
    """
    from nlds_vines.plotting.chosen_panels import drawn, let_figures_be_shown, save_figure
    from nlds_vines.plotting.page import count_in, others_beside, page_of, set_title, sheet

    let_figures_be_shown()
    look = Look(columns, width, title)
    page = page_of(look.columns, look.width)
    if ax is not None and (title is not None or width is not None):
        raise RequestError("title and width are those of a page, not of axes")
    target = _target(to)
    if ax is not None and target is not None:
        raise RequestError("to is the file of a page, not of axes: save the figure of the axes")
    others = [marks] if isinstance(marks, str | os.PathLike) else [*marks]
    with read(archive) as view, sheet(style):
        job = _drawn_by(view)
        picture: Drawing = job.picture()
        # of an ensemble, `show` may ask for the drawing of a scan
        words = {word.strip() for word in show.split(",")} if show else set()
        if job is JOBS[SCAN] or (
            view.content == SCAN and show is not None and words.isdisjoint(picture.names(view))
        ):
            picture = replace(JOBS[SCAN].picture(), manifold=manifold)
        elif manifold:
            raise RequestError(
                f"{view.path} holds a {view.content}: the manifold is for maps alone"
            )
        if others and view.content != RESPONSE_HISTORY:
            raise RequestError(f"{view.path} holds a {view.content}: no branches are drawn over it")
        there = others_beside(ax)
        figure = drawn(view, lambda opened: picture.figure(opened, show, page, ax))
        count_in(figure, frequency, view, others=there)
        if look.title is not None:
            set_title(figure, look.title)
        if others:
            from nlds_vines.upkeep.branches_picture import draw_branches

            for other in others:
                draw_branches(figure, view, other, ax is not None)
        if target is not None:
            origin = "scan_hash", view.text("scan_hash")
            save_figure(figure, target, view.text("title"), origin)
        return figure


def _target(to: object) -> Path | None:
    if to is None:
        return None
    if not isinstance(to, str | os.PathLike):
        raise RequestError(f"to = {shown(to)} must be a path")
    path = Path(to)
    check_plot(path, "to")
    return path


def _carry_out(options: argparse.Namespace) -> int:
    archive = existing(options.archive)
    if options.show == "?":
        meanings = panels(archive)
        say(*(f"{name:<26}{meaning}" for name, meaning in meanings.items()))
        return DONE
    path = archive.with_suffix(".png") if options.output is None else Path(options.output)
    check_plot(path, "output")
    refuse_same(archive, path)
    refuse_replacing("picture", path, options.overwrite)
    look = look_of(options)
    plot(
        archive, options.show, to=path, columns=look.columns, width=look.width, title=look.title,
        style=options.style, marks=options.marks, manifold=options.manifold,
        frequency=options.frequency,
    )  # fmt: skip
    say(path)
    return DONE


def _declare(parser: Parser) -> None:
    add = parser.add_argument
    add("archive", metavar="FILE.h5", help="an archive that is complete")
    add("-o", "--output", metavar="FILE", help="picture: .png, .pdf or .svg [FILE.png]")
    add("--show", metavar="WHAT", help="panels; of a scan: quantities; ? names them")
    for option in LOOK:
        option.add(parser)
    add("--style", metavar="SHEET", help="a style sheet of matplotlib's, by name or path")
    add(
        "--mark", dest="marks", action="append", default=[], metavar="FILE.h5",
        help="over a sweep's energies: the branches of a continuation along omega; several combine",
    )  # fmt: skip
    add(
        "--manifold", action="store_true",
        help="of maps: draw the bounds of 1:1 motion in closed form, of a free mass between two "
        "rigid walls",
    )  # fmt: skip
    FREQUENCY.add(parser)
    add("--overwrite", action="store_true", help="replace a picture")


main = Command(
    "plot", "Draw a finished archive; nothing is computed.", _EXAMPLES, _declare, _carry_out
).main
