"""Arguments of another type than a public function takes: one line that names the argument."""

import pytest
from made_up import make_scan, write

import nlds_vines as nv
from nlds_vines.portrait.request_file import load_portrait

CALLS = {
    "system = 7; of simulate": lambda: nv.simulate(7, 1),
    "system = 7 of load_system": lambda: nv.load_system(7),
    "'ssul-set6' for ssul-set66": lambda: nv.classify("ssul-set66"),
    "'ssull' of load_scan": lambda: nv.load_scan("ssull"),
    "'ssull' of continue_branch": lambda: nv.continue_branch("ssull", "omega", (5.0, 6.0)),
    "'here' for a start": lambda: nv.simulate("tmd", 1, start="here"),
    "start with a word": lambda: nv.simulate("tmd", 1, start=[0, "a", 0, 0]),
    "record of simulate": lambda: nv.simulate("tmd", 1, record=7),
    "orbit of spectrum": lambda: nv.spectrum("tmd"),
    "archive of read": lambda: nv.read(7),
    "plane of two": lambda: nv.continue_branch("tmd", "omega", (5.0, 6.0), plane=("P", 1.0)),
    "start of continue_branch": lambda: nv.continue_branch(
        "tmd", "omega", (5.0, 6.0), start=[None], period=1
    ),
    "P = 1000... of load_system": lambda: nv.load_system("tmd", P=10**5000),
    "archive of orbit_of": lambda: nv.orbit_of(7),
    "to = 7 of scan": lambda: nv.scan(to=7),
    "output of scan": lambda: nv.scan(to="a\0b.h5"),
    "shard of scan": lambda: nv.scan(shard=3),
    "to of tune": lambda: nv.tune(to=b"a.h5"),
    "to of transient_lifetimes": lambda: nv.transient_lifetimes(to=[]),
    "output of response_curves": lambda: nv.response_curves(output=None),
    "start of portrait": lambda: nv.orbit_portrait(start=7),
    "portrait = 3": lambda: nv.orbit_portrait(3),
    "'x.gif' to orbit_portrait": lambda: nv.orbit_portrait("tmd", to="x.gif"),
    "'pannels' of portrait": lambda: nv.orbit_portrait("tmd", pannels=["energy"]),
    "show beside a request": lambda: nv.orbit_portrait(load_portrait("tmd"), show=3),
    "scan = 3": lambda: nv.scan(3),
    "UTF-8 of an output": lambda: nv.scan(None, to="a\udcff.h5"),
    "threads of scan": lambda: nv.scan(threads=0),
    "resume beside overwrite": lambda: nv.scan(resume=True, overwrite=True),
}


@pytest.mark.parametrize("case", CALLS)
def test_an_argument_of_another_type_is_named_in_one_line(case, here, error_of):
    assert case.split()[0] in error_of(CALLS[case])
    assert not list(here.iterdir())


def test_a_style_that_is_no_name_is_refused(tmp_path):
    archive = write(tmp_path / "scan.h5", make_scan())
    for style in ("/dev/zero", tmp_path):
        with pytest.raises(nv.RequestError, match=r"^style"):
            nv.plot(archive, style=style)
