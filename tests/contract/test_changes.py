"""New axes, starts, quantities, settings and tasks: small diffs, applied to a copy here."""

import json
from functools import cache

import commands
import numpy as np
import pytest
from scipy.linalg import expm
from support import amplitudes, linear_flow

import nlds_vines as nv

SCAN_ALONG_IT = """
import json
import nlds_vines as nv
from nlds_vines.__main__ import main
scan = ["bifurcation", "--system", "tmd", "--start", "deflected", "--quiet", "--transient", "0",
        "--periods", "2", "--record", "section", "--vary", "stiffness_ratio=0.01:0.02:3"]
assert main([*scan, "-o", "new.h5", "--plot", "new.png"]) == 0
assert main(["rerun", "new.h5", "-o", "again.h5", "--quiet"]) == 0
with nv.read("new.h5") as view:
    k2, start, section = (view[name].tolist() for name in ("k2", "start", "section"))
print(json.dumps([k2, start, section, nv.open_archive("new.h5").request.to_toml()]))
"""


@pytest.fixture(scope="module")
def copy(tmp_path_factory):
    """Return a function that runs Python in a copy of the package with a change applied to it."""

    @cache
    def changed(change):
        return commands.changed(tmp_path_factory.mktemp("changed"), change)

    def python(change, *words, status=0, **environment):
        folder = changed(change)
        done = commands.python(*words, cwd=folder, PYTHONPATH=str(folder), **environment)
        assert done.returncode == status, done.stderr
        return done.stderr if status else done.stdout

    return python


def test_scans_know_a_new_axis_and_a_new_start(copy):
    text = copy("axis_and_start", "-c", SCAN_ALONG_IT, NUMBA_DISABLE_JIT="1")
    k2, start, section, toml = json.loads(text.splitlines()[-1])
    p = nv.load_system("tmd").parameters
    np.testing.assert_allclose(k2, np.linspace(0.01, 0.02, 3) * p["k1"], rtol=1e-15)
    assert start == ["deflected"]
    assert 'policy = "deflected"' in toml
    for value, states in zip(k2, section, strict=True):
        flow = expm(linear_flow({**p, "k2": value}) * 2 * np.pi / p["omega"])
        state = flow @ [p["P"] / p["k1"], 0.0, 0.0, 0.0, 1.0, 0.0]  # the last two: cos, sin
        after = [state[:4], (flow @ state)[:4]]
        np.testing.assert_allclose(states[0], after, rtol=0, atol=1e-13)
    # the unit of the axis may vary beside it
    axes = ("--vary", "stiffness_ratio=0.01:0.02:3", "--vary", "k1=3e4:4e4:3", "--dry-run")
    command = ("-m", "nlds_vines", "bifurcation", "--system", "tmd", *axes)
    text = copy("axis_and_start", *command)
    assert "k₂/k₁, k₁" in text
    assert "k2 =" not in text


WORDS = "width of the section, the largest less the least x1 at t = nT"

RECORD_IT = """
import json
from pathlib import Path
import nlds_vines as nv
from nlds_vines.explore.map_data import stored
from nlds_vines.explore.map_view import column, numbers_of, shows_of
from nlds_vines.model.quantities import QUANTITIES
from nlds_vines.engine.records import WANTS
from nlds_vines.upkeep.export import main as export

omega, P = {"values": [6.0, 6.5, 7.0]}, {"values": [300.0, 600.0]}
sampling, found = {"transient": 2, "periods": 5}, {"last": WANTS[-1]}
for name, vary, want in (
    ("line", {"omega": omega}, ["section", "width"]),
    ("alone", {"omega": omega}, ["width"]),
    ("map", {"omega": omega, "P": P}, ["width"]),
):
    document = {"title": name, "system": "tmd", "vary": vary, "sampling": sampling}
    path = Path(f"{name}.h5")
    nv.scan({**document, "record": {"want": want}}, to=path)
    figure = nv.plot(path)
    with nv.read(path) as view:
        entry = view.describe("width")
        found[name] = {
            "datasets": sorted(view.names),
            "about": [entry.units, entry.long_name, list(entry.dims)],
            "width": view["width"].tolist(),
            "section": view["section"].tolist() if "section" in view else [],
            "labels": [axes.get_ylabel() for axes in figure.axes],
        }
one = stored(Path("map.h5"))
shown = next(show for show in shows_of(one) if show.name == "width")
found["page"] = [shown.title, shown.unit, column(one, "width").ravel().tolist()]
found["told"] = [row for row in numbers_of(one) if row[0] == "width"]
found["exported"] = export(["line.h5", "--quiet"]), Path("line.csv").read_text().splitlines()[0]
print(json.dumps(found))
"""


def test_archives_pictures_pages_and_tables_have_a_new_quantity(copy):
    text = copy("quantity", "-c", RECORD_IT, NUMBA_DISABLE_JIT="1")
    computed = json.loads(text.splitlines()[-1])
    line, alone = computed["line"], computed["alone"]
    assert computed["last"] == "width"  # of `[record] want`: what was before keeps its place
    assert line["datasets"] == ["section", "status", "width"]
    assert alone["datasets"] == ["status", "width"]
    assert line["about"] == ["m", WORDS, ["omega", "start"]]
    x1 = np.array(line["section"])[..., 0]
    assert x1.shape == (3, 1, 5)
    widths = x1.max(axis=-1) - x1.min(axis=-1)
    assert (widths > 0).all()
    assert line["width"] == alone["width"] == widths.tolist()
    assert computed["alone"]["labels"] == ["width of the section [m]"]
    assert "width of the section [m]" in computed["map"]["labels"]
    title, unit, column = computed["page"]
    assert (title, unit) == ("width of the section", "m")
    np.testing.assert_array_equal(column, np.float32(np.ravel(computed["map"]["width"])))
    assert computed["told"] == [["width", "width of the section", "m", ""]]
    status, heads = computed["exported"]
    assert status == 0
    assert "width" in heads
    # and the page of datasets tells it
    copy("quantity", "docs/site/reference.py")
    page = copy("quantity", "-c", "print(open('docs/datasets.md').read())")
    assert f"| `width` | axes, start | m | {WORDS} | width | all kinds |" in page


SET_IT = """
from nlds_vines.tuning.request import load_tuning
usual, other = load_tuning("tmd"), load_tuning({"system": "tmd", "search": {"patience": 7}})
assert other.search.patience == 7 and usual.search.patience == 20
assert "patience = 7" in other.to_toml() and "patience = 20" in usual.to_toml()
assert usual.hash != other.hash == load_tuning(other.document()).hash
"""


def test_files_hashes_and_options_know_a_new_setting(copy):
    assert copy("setting", "-c", SET_IT) == ""
    tuning = "setting", "-m", "nlds_vines", "tuning"
    assert "generations without gain that end a search [20]" in copy(*tuning, "--help-all")
    assert copy(*tuning, "--patience", "0", status=2) == (
        "nlds-vines tuning: error: command line: [search]: "
        "patience = 0 must be a whole number from 1 to 1000\n"
    )


RUN_IT = """
import json
from pathlib import Path
import nlds_vines as nv
from nlds_vines.__main__ import main
Path("own.toml").write_text("system = 'tmd'\\n[set]\\nc1 = 400.0\\n[band]\\ncount = 4\\n")
frf = ["frf", "own.toml", "-o", "own.h5", "--high", "6.5", "--quiet"]
assert main([*frf, "--plot", "own.png"]) == 0
assert main([*frf, "--resume"]) == 0  # complete already
assert main(["plot", "own.h5", "-o", "own.svg"]) == 0
assert main(["export", "own.h5", "-o", "own.csv"]) == 0
assert main(["rerun", "own.h5", "-o", "again.h5"]) == 0
assert all(Path(name).stat().st_size > 0 for name in ("own.png", "own.svg", "own.csv"))
one, other = nv.open_archive("own.h5"), nv.frf("own.toml", quiet=True, band={"high": 6.5})
assert one.request.hash == other.request.hash
print(json.dumps([one.omega.tolist(), one.x1.tolist(), other.x1.tolist(), one.lines()]))
"""


def test_a_new_task_is_a_command_a_file_a_function_and_an_archive(copy):
    text = copy("task", "-c", RUN_IT)
    omega, x1, again, lines = json.loads(text.splitlines()[-1])
    np.testing.assert_array_equal(omega, np.linspace(5.0, 6.5, 4))
    p = nv.load_system("tmd", c1=400.0).parameters
    alone = [abs(amplitudes({**p, "omega": value})[0]) for value in omega]
    np.testing.assert_allclose(x1, alone, rtol=1e-12)
    assert x1 == again
    assert lines == [f"largest x1: {max(x1):.6g} m at 6.0 rad/s".replace("6.0", "6")]


def test_a_new_task_tells_and_refuses_its_options_and_keeps_what_exists(copy):
    frf = "task", "-m", "nlds_vines", "frf"
    assert "lowest frequency [rad/s] [5]" in copy(*frf, "--help")
    assert "frf" in copy("task", "-m", "nlds_vines", "--help")
    for words, line in (
        (["--low", "9"], "command line: [band]: low = 9 must be below high = 8"),
        (["--count", "1"], "command line: [band]: count = 1 must be a whole number from 2"),
    ):
        error = copy(*frf, *words, status=2)
        assert error.startswith(f"nlds-vines frf: error: {line}")
        assert error.count("\n") == 1
    stored = *frf, "-o", "kept.h5"
    assert "archive:  kept.h5" in copy(*stored, "--dry-run")
    copy(*stored, "--quiet")
    assert "kept.h5' exists" in copy(*stored, "--low", "6", status=2)
