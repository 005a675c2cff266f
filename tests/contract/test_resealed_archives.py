"""Archives whose content was changed and whose checksums were made anew: one line, and verify."""

from contextlib import suppress

import h5py
import numpy as np
import pytest
from made_up import MAP, make_scan, write

import nlds_vines as nv
from nlds_vines.__main__ import main
from nlds_vines.archives import durable
from nlds_vines.archives.view import whole_crc


def put(name, value):
    def change(file):
        file[name][...] = value
        if file[name].dtype.kind == "O":
            file[name].attrs["crc32"] = np.uint32(whole_crc(file[name]))

    return change


def attribute(name, value, of="status"):
    def change(file):
        (file[of] if of else file).attrs[name] = value

    return change


CHANGES = {
    "a status without a word": put("status", 99),
    "a regime without a word": put("regime", -5),
    "too few words": attribute("flag_meanings", "ok"),
    "a number for words": attribute("flag_meanings", 3),
    "codes in words": attribute("flag_values", "abc"),
    "codes that are no numbers": attribute("flag_values", np.array([np.nan, 1.0])),
    "codes in a square": attribute("flag_values", np.zeros((2, 2), int)),
    "a period of 0": put("label", "0T,0"),
    "a period of 0 after chaos": put("label", "transient chaos to 00T,0"),
    "lists within lists": attribute("scan", "a = " + "[" * 5000 + "]" * 5000, of=""),
    "tables within tables": attribute("scan", "a" + ".a" * 3000 + " = 1", of=""),
    "a number for its scales": attribute("DIMENSION_LIST", 7),
    "a text for its scales": attribute("DIMENSION_LIST", "omega"),
    "no TOML": attribute("scan", "=", of=""),
}

COMMANDS = (
    ["plot", "a.h5", "-o", "a.png", "--overwrite"],
    ["plot", "a.h5", "--show", "?"],
    ["export", "a.h5", "-o", "a.csv", "--overwrite"],
    ["report", "a.h5", "-o", "a.html", "--overwrite"],
    ["rerun", "a.h5", "-o", "b.h5", "--dry-run"],
    ["status", "a.h5"],
    ["diff", "a.h5", "o.h5"],
)


@pytest.fixture(scope="module")
def sound(tmp_path_factory):
    folder = tmp_path_factory.mktemp("resealed")
    return {
        vary is None: write(
            folder / f"{vary is None}.h5", make_scan(("energy", "regime"), vary=vary)
        )
        for vary in (None, MAP)
    }


@pytest.fixture(params=[True, False], ids=["diagram", "map"])
def path(request, sound, here):
    for name in ("a.h5", "o.h5"):
        (here / name).write_bytes(sound[request.param].read_bytes())
    return here / "a.h5"


def reseal(path, change):
    with h5py.File(path, "r+") as file:
        change(file)
    durable.seal(path)


@pytest.mark.slow("draws each")
@pytest.mark.parametrize("case", CHANGES)
def test_what_means_nothing_is_one_line_and_found(path, capsys, case):
    reseal(path, CHANGES[case])
    problems = nv.verify(path)
    assert problems
    assert not any("\n" in line for line in problems)
    for words in COMMANDS:
        status = main(words)
        err = capsys.readouterr().err
        assert status in (0, 1, 2)
        assert err.count("\n") == (status == 2), (words, err)
    with suppress(nv.RequestError):
        nv.read(path).to_csv(path.with_suffix(".txt"))


def test_another_kind_of_content_than_it_says_is_one_line(path, capsys):
    for content in ("survey", "tuning", "continuation", "page of response curves"):
        reseal(path, attribute("content", content, of=""))
        assert main(["plot", str(path), "--show", "?"]) in (0, 2)
        assert capsys.readouterr().err.count("\n") <= 1
