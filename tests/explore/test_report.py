"""The page without a server: its size, its numbers, its words; branches and claims on it."""

import json
import re
from pathlib import Path

import numpy as np
import pytest
from conftest import MAP, filled, made_up

import nlds_vines as nv
from nlds_vines.__main__ import main
from nlds_vines.explore.map_data import stored
from nlds_vines.explore.map_view import column, label_codes, painted, shows_of

pytest.importorskip("bokeh", reason="Bokeh is not installed")

from bokeh.core.serialization import Deserializer

from nlds_vines.explore.report_page import MOST_BYTES, coded, report_page, rounded


def arguments_of(html):
    """Return the arguments of the script of a page by name, as Bokeh decodes them."""
    text = re.search(r'application/json" id="[^"]*">(.*?)</script>', html, re.DOTALL)[1]
    (document,) = json.loads(text).values()
    callbacks = Deserializer().decode(document)["callbacks"]["document_ready"]
    return next(act.args for act in callbacks if "shows" in act.args)


def test_numbers_keep_four_digits_and_states_sixteen_bits_of_their_range():
    values = np.array([1.0, -3.14159265, 1e-30, 1e30, 0.0, np.nan, np.inf, -np.inf], np.float32)
    rounded_values = rounded(values)
    np.testing.assert_array_equal(np.isfinite(rounded_values), np.isfinite(values))
    nonzero = np.isfinite(values) & (values != 0)
    assert (np.abs(rounded_values[nonzero] / values[nonzero] - 1) <= 2.0**-13).all()
    assert rounded_values[4] == 0
    states = np.random.default_rng(1).normal(size=(50, 3, 4))
    states[7, 1] = np.nan
    codes, low, step = coded(states)
    decoded = np.where(codes == 65535, np.nan, low + codes * step)
    np.testing.assert_allclose(decoded, states, atol=0.51 * np.max(step))


@pytest.fixture(scope="module")
def page(small_map):
    return report_page(stored(small_map)).html


def test_the_page_holds_what_the_archive_does(page, small_map):
    arguments = arguments_of(page)
    archive, columns = stored(small_map), arguments["columns"].data
    assert arguments["labels"] == label_codes(archive)[0]
    np.testing.assert_array_equal(columns["label"], column(archive, "label").ravel())
    np.testing.assert_allclose(columns["E1max"], column(archive, "E1max").ravel(), rtol=2e-4)
    states = arguments["low"] + arguments["codes"].reshape(-1, 30, 4) * np.array(arguments["step"])
    expected = archive.lanes("section").reshape(-1, 30, 4)
    np.testing.assert_allclose(states, expected, atol=1.1 * max(arguments["step"]))
    images = arguments["images"].data
    (show,) = [one for one in shows_of(archive) if one.name == "E1max"]
    np.testing.assert_array_equal(images["E1max:1"][0], painted(archive, show, 1).codes)


def test_the_page_has_a_place_for_each_figure_and_asks_for_nothing_from_outside(page, small_map):
    roots = json.loads(re.search(r'"roots":(\{[^}]*\})', page)[1])
    assert len(roots) == 9  # controls, tip, map, legend, hint, key, words, two phase planes
    assert all(f'id="{place}"' in page for place in roots.values())
    # it asks for nothing from outside
    assert "Content-Security-Policy" in page
    assert "default-src 'none'" in page
    assert not re.search(r"<(script|link|img)[^>]*(src|href)=[\"']?(https?:|//)", page)
    # it tells nothing of the machine of its author
    about = stored(small_map).about
    for name in ("machine", "history"):
        assert str(about[name]) not in page
    assert str(Path.home()) not in page
    assert str(small_map.parent) not in page


def test_words_of_an_archive_do_no_harm(folder):
    title = "</script><script>alert(1)</script><b>"
    path = made_up({**MAP, "title": title}, folder / "bad.h5")
    html = report_page(stored(path)).html
    assert "<script>alert(1)" not in html
    assert "&lt;/script&gt;" in html


@pytest.mark.parametrize(("sides", "count"), [(300, 1), (150, 4)])
def test_a_large_map_fits_into_a_mail(sides, count):
    """Of random numbers, which nothing makes smaller: a real map takes less."""
    vary = {"omega": np.linspace(5.0, 8.0, sides), "P": np.linspace(400.0, 900.0, sides)}
    start, sampling = {"policy": "random", "count": count}, {"transient": 1, "periods": 12}
    document = {**MAP, "vary": vary, "start": start, "sampling": sampling}
    report = report_page(filled(document))
    assert report.size <= MOST_BYTES
    arguments = arguments_of(report.html)
    assert arguments["columns"].data["label"].size == 90_000
    assert "E1max" in arguments["columns"].data
    assert arguments["points"] >= 1
    assert "holds" in report.left_out


def test_the_command_writes_the_page_and_says_its_size(small_map, tmp_path, answer):
    output = tmp_path / "page.html"
    assert "MB" in answer("report", small_map, "-o", output)
    assert "a small map" in output.read_text(encoding="utf-8")
    assert [path.name for path in tmp_path.iterdir()] == ["page.html"]


def test_what_are_no_branches_is_one_line(small_map, tmp_path, refusal):
    output = tmp_path / "x.html"
    line = refusal("report", small_map, "--branches", small_map, "-o", output)
    assert "not a continuation" in line
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
    vary = {"P": [700.0, 800.0, 900.0], "C": [0.06, 0.07]}
    path, output = made_up({**MAP, "vary": vary}, folder / "PC.h5"), folder / "x.html"
    assert "continues along omega" in refusal("report", path, "--branches", branches, "-o", output)
