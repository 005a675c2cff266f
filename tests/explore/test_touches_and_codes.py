"""Touches of a diagram and kinds of modulation of a map, as a page takes them."""

import numpy as np
from conftest import DIAGRAM, MAP

from nlds_vines.bifurcation.request import load_scan
from nlds_vines.explore.map_data import empty
from nlds_vines.explore.map_view import column, diagram_values, shows_of
from nlds_vines.explore.report_page import report_page
from nlds_vines.orbits.records import CAPTURE_FLAGS


def test_a_diagram_shows_the_section_at_impact():
    want = {"want": ["section", "impact_section", "regime"]}
    archive = empty(load_scan({**DIAGRAM, "record": want}))
    speeds = archive.arrays["impact_speed"]
    assert speeds.shape == (9, 1, 4 * 30)  # room for four impacts a period
    speeds[...] = np.arange(speeds.size).reshape(speeds.shape)
    shows = {show.name: show for show in shows_of(archive)}
    assert list(shows)[:4] == ["x2", "x1", "impact_speed", "impact_phase"]
    assert (shows["impact_speed"].points, shows["impact_speed"].unit) == (True, "m/s")
    drawn = diagram_values(archive, shows["impact_speed"])
    np.testing.assert_array_equal(drawn.ravel(), np.arange(speeds.size))
    assert '"impact_speed"' not in report_page(archive).html  # it holds nothing of touches


def test_a_map_shows_the_kind_of_modulation():
    twice = {**MAP, "system": "vi-nes", "record": {"want": ["modulation", "impact_section"]}}
    archive = empty(load_scan(twice))
    codes = archive.arrays["capture"]
    codes[...] = np.arange(codes.size).reshape(codes.shape) % 5 - 1
    (show,) = [one for one in shows_of(archive) if one.name == "capture"]
    words = [word for word, *_ in show.classes]
    assert words[1:] == ["no impacts", "strongly modulated", "sustained 1:1", "more impacts"]
    assert len(words) == len(CAPTURE_FLAGS) + 1
    np.testing.assert_array_equal(column(archive, "capture").ravel(), np.arange(codes.size) % 5)
    assert "impact_phase" not in archive.arrays  # a map has no room for touches
