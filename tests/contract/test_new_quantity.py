"""A new recorded number is a line: made here in a copy, by a diff."""

import json

import commands
import numpy as np
import pytest

WORDS = "width of the section, the largest less the least x1 at t = nT"

PROGRAM = """
import json, sys
from pathlib import Path
import numpy as np
from nlds_vines.archives.archive import read
from nlds_vines.bifurcation.request import load_scan
from nlds_vines.bifurcation.run import run
from nlds_vines.explore.map_data import stored
from nlds_vines.explore.map_view import column, numbers_of, shows_of
from nlds_vines.model.quantities import QUANTITIES
from nlds_vines.orbits.records import WANTS
from nlds_vines.upkeep.export import main as export
from nlds_vines.upkeep.plot import plot

omega, P = {"values": [6.0, 6.5, 7.0]}, {"values": [300.0, 600.0]}
sampling, found = {"transient": 2, "periods": 5}, {"last": WANTS[-1]}
for name, vary, want in (
    ("line", {"omega": omega}, ["section", "width"]),
    ("alone", {"omega": omega}, ["width"]),
    ("map", {"omega": omega, "P": P}, ["width"]),
):
    document = {"title": name, "system": "tmd", "vary": vary, "sampling": sampling}
    path = Path(f"{name}.h5")
    run(load_scan({**document, "record": {"want": want}}), path)
    figure = plot(path)
    with read(path) as view:
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


@pytest.fixture(scope="module")
def changed(tmp_path_factory):
    return commands.changed(tmp_path_factory.mktemp("changed"), "quantity")


def output_of(folder, *words):
    """Return the output of a program in a copy, with kernels as plain Python."""
    return commands.printed(*words, cwd=folder, PYTHONPATH=str(folder), NUMBA_DISABLE_JIT="1")


@pytest.fixture(scope="module")
def computed(changed):
    return json.loads(output_of(changed, "-c", PROGRAM).splitlines()[-1])


def test_the_archive_has_it(computed):
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


def test_pictures_show_it(computed):
    assert computed["alone"]["labels"] == ["width of the section [m]"]
    assert "width of the section [m]" in computed["map"]["labels"]


def test_pages_and_tables_show_it(computed):
    title, unit, column = computed["page"]
    assert (title, unit) == ("width of the section", "m")
    np.testing.assert_array_equal(column, np.float32(np.ravel(computed["map"]["width"])))
    assert computed["told"] == [["width", "width of the section", "m", ""]]
    status, heads = computed["exported"]
    assert status == 0
    assert "width" in heads


def test_the_page_of_datasets_tells_it(changed):
    output_of(changed, "docs/site/reference.py")
    page = (changed / "docs" / "datasets.md").read_text(encoding="utf-8")
    assert f"| `width` | axes, start | m | {WORDS} | width | all kinds |" in page
