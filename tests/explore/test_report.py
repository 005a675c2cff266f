"""The page without a server: its size, its numbers, its words; branches and claims on it."""

import base64
import json
import re
import zlib

import numpy as np
import pytest
from conftest import MAP

import nlds_vines as nv
from nlds_vines.__main__ import main
from nlds_vines.bifurcation.request import load_scan
from nlds_vines.explore.cell_columns import columns
from nlds_vines.explore.map_choices import label_words
from nlds_vines.explore.map_data import Stored, stored
from scans import unfilled

pytest.importorskip("bokeh", reason="Bokeh is not installed")

from nlds_vines.explore.report.report_page import MOST_BYTES, coded, packed, report_page, rounded


def unpacked(html):
    """Return the header of a page and its columns, as a browser unpacks them."""
    meta = json.loads(re.search(r'id="meta">(.*?)</script>', html, re.DOTALL)[1])
    texts = re.search(r'id="packed">(.*?)</script>', html, re.DOTALL)[1].split()
    found = {}
    for entry, text in zip(meta["entries"], texts, strict=True):
        dtype, planes = np.dtype(f"<{entry['kind']}"), zlib.decompress(base64.b64decode(text))
        bytes_ = np.frombuffer(planes, np.uint8).reshape(dtype.itemsize, entry["length"]).T
        found[entry["name"]] = np.ascontiguousarray(bytes_).view(dtype).ravel()
    return meta, found


def test_numbers_keep_four_digits():
    values = np.array([1.0, -3.14159265, 1e-30, 1e30, 0.0, np.nan, np.inf, -np.inf], np.float32)
    found = rounded(values)
    np.testing.assert_array_equal(np.isfinite(found), np.isfinite(values))
    known = np.isfinite(values) & (values != 0)
    assert (np.abs(found[known] / values[known] - 1) <= 2.0**-13).all()
    assert found[4] == 0


def test_states_keep_sixteen_bits_of_their_range():
    states = np.random.default_rng(1).normal(size=(50, 3, 4))
    states[7, 1] = np.nan
    codes, ranges = coded(states)
    low, high = np.array(ranges).T
    found = np.where(codes == 65535, np.nan, low + codes * ((high - low) / 65534))
    np.testing.assert_allclose(found, states, atol=0.51 * np.max(high - low) / 65534)


@pytest.mark.parametrize(
    "values",
    [np.arange(5, dtype="u2"), np.array([1.5, np.nan], "f4"), np.array([-1, 7], "i1")],
)
def test_a_packed_column_is_unpacked(values):
    one = packed("a", values)
    meta = json.dumps({"entries": [one.entry]})
    _, found = unpacked(f'id="meta">{meta}</script> id="packed">{one.text}</script>')
    np.testing.assert_array_equal(found["a"], values)


@pytest.fixture(scope="module")
def page(small_map):
    return report_page(stored(small_map)).html


def test_the_page_holds_what_the_archive_does(page, small_map):
    meta, found = unpacked(page)
    archive = stored(small_map)
    assert meta["labels"] == label_words(archive)
    everything = columns(archive)
    np.testing.assert_array_equal(found["label"], everything["label"])
    np.testing.assert_allclose(found["E1max"], everything["E1max"], rtol=2e-4)
    (low, high) = np.array(meta["ranges"]).T
    states = low + found["section"].reshape(-1, 30, 4) * ((high - low) / 65534)
    expected = archive.lanes("section").reshape(-1, 30, 4)
    np.testing.assert_allclose(states, expected, atol=1e-4 * np.max(high - low))


def test_each_figure_has_its_place_on_the_page(page):
    roots = json.loads(re.search(r'"roots":(\{[^}]*\})', page)[1])
    assert len(roots) == 3  # the map and two phase planes
    assert all(f'id="{place}"' in page for place in roots.values())
    for name in ("label", "where", "evidence"):  # what the script fills for the chosen cell
        assert f'id="{name}"' in page


def test_the_page_asks_for_nothing_from_outside(page):
    assert "Content-Security-Policy" in page
    assert "default-src 'none'" in page
    assert not re.search(r"<(script|link|img)[^>]*(src|href)=[\"']?(https?:|//)", page)


def test_words_of_an_archive_do_no_harm(folder):
    title = "</script><script>alert(1)</script><b>"
    path = nv.scan({**MAP, "title": title}, to=folder / "bad.h5")
    html = report_page(stored(path)).html
    assert "<script>alert(1)" not in html
    assert "&lt;/script&gt;" in html


def big(sides, count, want):
    """Return made-up results of a map of many cells, of three regimes and of numbers that vary."""
    scan = load_scan(
        {
            "system": "ssul-set6",
            "vary": {
                "omega": {"start": 5.0, "stop": 8.0, "num": sides},
                "P": {"start": 400.0, "stop": 900.0, "num": sides},
            },
            "start": {"policy": "random", "count": count},
            "sampling": {"transient": 1, "periods": 12},
            "record": {"want": want},
        }
    )
    generator, arrays = np.random.default_rng(0), {}
    for name, array in unfilled(scan).items():
        if name == "label":
            words = np.array(["T,1", "T,0", "3T,2", "chaos"], dtype=object)
            array[...] = words[generator.integers(0, 4, array.shape)]
        elif array.dtype.kind == "f":
            array[...] = generator.normal(size=array.shape)
        else:
            array[...] = 0
        arrays[name] = array
    return Stored(scan, arrays)


@pytest.mark.parametrize(("sides", "count"), [(300, 1), (150, 4)])
def test_a_large_map_fits_into_a_mail(sides, count):
    """Of random numbers, which nothing makes smaller: a real map takes less."""
    want = ["section", "impacts", "energy", "regime", "lyapunov", "settling", "evidence"]
    report = report_page(big(sides, count, want))
    assert report.size <= MOST_BYTES
    _, found = unpacked(report.html)
    assert found["label"].size == 90_000
    assert {"E1max", "section"} <= set(found)
    assert "holds" in report.left_out


def test_the_command_writes_the_page_and_says_its_size(small_map, tmp_path, answer):
    output = tmp_path / "page.html"
    assert "MB" in answer("report", small_map, "-o", output)
    assert "a small map" in output.read_text(encoding="utf-8")
    assert [path.name for path in tmp_path.iterdir()] == ["page.html"]


def test_what_are_no_branches_is_one_line(small_map, tmp_path, refusal):
    output = tmp_path / "x.html"
    found = refusal("report", small_map, "--branches", small_map, "-o", output)
    assert found.count("\n") == 1
    assert "not a continuation" in found
    assert not output.exists()


@pytest.fixture(scope="module")
def branches(folder):
    path = folder / "branches.h5"
    arguments = ["--along", "omega=7.3:7.6", "--doublings", "1", "--unstable", "30", "--quiet"]
    assert main(["continuation", *arguments, "-o", str(path)]) == 0
    return path


@pytest.mark.kernels
@pytest.mark.parametrize("name", ["diagram", "map"])
def test_branches_and_special_points_are_on_the_page(
    name, branches, folder, small_map, small_diagram, ask
):
    output = folder / f"{name}-branches.html"
    assert ask("report", folder / f"{name}.h5", "--branches", branches, "-o", output).err == ""
    html = output.read_text(encoding="utf-8")
    special = nv.open_archive(branches).special_points
    assert len(special)
    for row in special:
        assert f"<td>{row.kind}</td><td>omega = {row.value:.8g}</td>" in html
    assert ('"name":"MultiLine"' in html) == (name == "diagram")
    assert html.count('"name":"Scatter"') > 2


@pytest.mark.kernels
def test_branches_of_another_parameter_are_refused(branches, folder, refusal):
    vary = {
        "P": {"start": 700.0, "stop": 900.0, "num": 3},
        "C": {"start": 0.06, "stop": 0.07, "num": 2},
    }
    path = nv.scan({**MAP, "vary": vary}, to=folder / "PC.h5")
    assert "continues along omega" in refusal(
        "report", path, "--branches", branches, "-o", folder / "x.html"
    )
