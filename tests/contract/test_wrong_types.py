"""Arguments of another type than a public function takes: one line that names the argument."""

import numpy as np
import pytest
from made_up import make_scan, write

import nlds_vines as nv
from nlds_vines.errors import typed
from nlds_vines.portrait.request_file import load_portrait
from paper.command import reproduce_paper

SCAN, TUNING, BRANCHES = nv.load_scan(), nv.load_tuning(), nv.load_continuation()
PARTS = {
    nv.Scan: {name: getattr(SCAN, name) for name in ("title", "system", "axes", "want")},
    nv.Tuning: {name: getattr(TUNING, name) for name in ("title", "system", "free")},
    nv.Continuation: {name: getattr(BRANCHES, name) for name in ("title", "system", "along")},
    nv.System: {"kind": "ssul", "parameters": dict(SCAN.system.parameters)},
}
"""Requests by their parts, of which a test exchanges one."""

CALLS = {
    "system = 7; of simulate": lambda: nv.simulate(7, 1),
    "system = 7 of load_system": lambda: nv.load_system(7),
    "'ssul-set6' for ssul-set66": lambda: nv.classify("ssul-set66"),
    "'ssull' of load_scan": lambda: nv.load_scan("ssull"),
    "'ssull' of continue_orbit": lambda: nv.continue_orbit("ssull", "omega", (5.0, 6.0)),
    "'here' for a start": lambda: nv.simulate("tmd", 1, start="here"),
    "start with a word": lambda: nv.simulate("tmd", 1, start=[0, "a", 0, 0]),
    "record of simulate": lambda: nv.simulate("tmd", 1, record=7),
    "orbit of spectrum": lambda: nv.spectrum("tmd"),
    "archive of read": lambda: nv.read(7),
    "start of simulate": lambda: nv.simulate("tmd", 1, start=10**400),
    "along of continue_orbit": lambda: nv.continue_orbit("tmd", ["omega"], (5.0, 6.0)),
    "plane of continue_orbit": lambda: nv.continue_orbit("tmd", "omega", (5.0, 6.0), plane=3),
    "plane of two": lambda: nv.continue_orbit("tmd", "omega", (5.0, 6.0), plane=("P", 1.0)),
    "start of continue_orbit": lambda: nv.continue_orbit(
        "tmd", "omega", (5.0, 6.0), start=[None], period=1
    ),
    "P of load_system": lambda: nv.load_system("tmd", P=np.zeros(3)),
    "P = 1000... of load_system": lambda: nv.load_system("tmd", P=10**5000),
    "changes of load_scan": lambda: nv.load_scan(None, 7),
    "changes of load_tuning": lambda: nv.load_tuning(None, np.zeros(3)),
    "changes of load_continuation": lambda: nv.load_continuation(None, np.zeros(3)),
    "source of ensemble_of": lambda: nv.ensemble_of(7),
    "archive of basin_measures": lambda: nv.basin_measures(None),
    "archive of orbit_of": lambda: nv.orbit_of(7),
    "output of bifurcation": lambda: nv.bifurcation(output=7),
    "plot of bifurcation": lambda: nv.bifurcation(plot="a\0b.png"),
    "shard of bifurcation": lambda: nv.bifurcation(shard=3),
    "scheduler of bifurcation": lambda: nv.bifurcation(scheduler=3),
    "overwrite of bifurcation": lambda: nv.bifurcation(overwrite=np.zeros(3)),
    "output of reproduce_paper": lambda: reproduce_paper(7),
    "only of reproduce_paper": lambda: reproduce_paper(only=7),
    "only of reproduce_paper, of lists": lambda: reproduce_paper(only=[[]]),
    "to of tune": lambda: nv.tune(to=b"a.h5"),
    "to of ensemble": lambda: nv.ensemble(to=[]),
    "resume of transients": lambda: nv.transients(resume=np.zeros(3)),
    "output of response_curves": lambda: nv.response_curves(output=None),
    "to of portray": lambda: nv.portray(to=7),
    "start of portrait": lambda: nv.portrait(start=7),
    "portrait = 3": lambda: nv.portrait(3),
    "'x.gif' to portray": lambda: nv.portray("tmd", to="x.gif"),
    "'pannels' of portrait": lambda: nv.portrait("tmd", pannels=["energy"]),
    "show beside a request": lambda: nv.portrait(load_portrait("tmd"), show=3),
    "scan = 3": lambda: nv.bifurcation(3),
    "UTF-8 of an output": lambda: nv.bifurcation(None, "a\udcff.h5"),
    "threads of bifurcation": lambda: nv.bifurcation(threads=0),
    "resume beside overwrite": lambda: nv.bifurcation(resume=True, overwrite=True),
    "system of Scan": lambda: replaced(nv.Scan, system="tmd"),
    "axes of Scan": lambda: replaced(nv.Scan, axes=("omega",)),
    "start of Scan": lambda: replaced(nv.Scan, start="rest"),
    "free of Tuning": lambda: replaced(nv.Tuning, free="k2"),
    "search of Tuning": lambda: replaced(nv.Tuning, search=None),
    "along of Continuation": lambda: replaced(nv.Continuation, along="omega"),
    "parameters of System": lambda: replaced(nv.System, parameters=[1, 2]),
}


def replaced(request, **parts):
    return request(**{**PARTS[request], **parts})


@pytest.mark.parametrize("case", CALLS)
def test_an_argument_of_another_type_is_named_in_one_line(case, here, error_of):
    assert case.split()[0] in error_of(CALLS[case])
    assert not list(here.iterdir())


def test_a_style_that_is_no_name_is_refused(tmp_path):
    archive = write(tmp_path / "scan.h5", make_scan())
    for style in (7, np.zeros(3), "/dev/zero", tmp_path):
        with pytest.raises(nv.RequestError, match=r"^style"):
            nv.plot(archive, style=style)


@typed
def divide(one: "float", other: "float | None" = None, *more: "int", **named: "str") -> "float":
    return one / other


def test_an_error_with_arguments_of_the_right_types_stays_what_it_is():
    assert divide(3, 2) == 1.5
    for error, call in (
        (ZeroDivisionError, lambda: divide(1.0, 0)),
        (TypeError, lambda: divide(1.0, None)),
        (TypeError, lambda: divide()),
    ):
        with pytest.raises(error) as told:
            call()
        assert not isinstance(told.value, nv.RequestError)


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda: divide("a", 2), "one = 'a' must be a number"),
        (lambda: divide(1, []), r"other = \[\] must be a number or None"),
        (lambda: divide(1, 0, 2, "b"), "more = 'b' must be a whole number"),
        (lambda: divide(1, 0, words=3), "words = 3 must be a text"),
    ],
)
def test_the_line_says_what_is_allowed(call, words):
    with pytest.raises(nv.RequestError, match=words):
        call()
