"""What a page knows of an archive: the same numbers, cell by cell; foreign files in one line."""

import h5py
import numpy as np
import pytest
from conftest import DIAGRAM, MAP

from nlds_vines.archives.archive import read
from nlds_vines.bifurcation.blocks import blocks_of
from nlds_vines.bifurcation.request import load_scan
from nlds_vines.bifurcation.run import Computer
from nlds_vines.explore import map_view
from nlds_vines.explore.live_orbit import live_orbit
from nlds_vines.explore.map_data import empty, stored
from nlds_vines.explore.report_page import report_page, section_points
from nlds_vines.orbits.records import CAPTURE_FLAGS, NOT_COMPUTED, OK, STATUS
from nlds_vines.plotting.palette import colors


def test_arrays_and_columns_are_those_of_the_archive(small_map):
    archive = stored(small_map)
    with read(small_map) as view:
        for name in ("label", "E1max", "section", "multipliers", "status"):
            np.testing.assert_array_equal(archive.arrays[name], view[name])
    assert archive.shape == (6, 4)
    assert archive.starts == ("random 0", "random 1")
    omega, P = archive.scan.axes
    assert archive.values_of((1, 2)) == {"omega": omega.values[1], "P": P.values[2]}
    # columns stand start by start and cell by cell
    words = map_view.label_codes(archive)[0]
    for i, j, k in ((0, 0, 0), (5, 3, 1), (2, 1, 0)):
        place = i * 4 + j, k
        assert words[map_view.column(archive, "label")[place]] == archive.arrays["label"][i, j, k]
        assert map_view.column(archive, "E1max")[place] == np.float32(
            archive.arrays["E1max"][i, j, k]
        )
    never = archive.lanes("settling") < 0
    np.testing.assert_array_equal(np.isnan(map_view.column(archive, "settling")), never)


@pytest.mark.kernels
def test_every_cell_live_has_the_label_of_the_archive(small_map):
    archive = stored(small_map)
    for cell in np.ndindex(archive.shape):
        for k in range(2):
            system = archive.system_of(cell)
            start = archive.start_of(cell, k, system)
            orbit = live_orbit(system, start.state, archive.scan)
            assert orbit.label == archive.arrays["label"][(*cell, k)]


def test_the_start_of_a_sweep_is_the_end_of_the_cell_before_if_it_is_known(small_sweeps):
    archive = stored(small_sweeps)
    for k, before in ((0, 3), (1, 5)):  # up and down, at cell 4
        start = archive.start_of((4, 0), k, archive.system_of((4, 0)))
        assert start.state == tuple(archive.arrays["section"][before, k, -1])
    edge = archive.start_of((0, 0), 0, archive.scan.system)
    assert edge.state is None
    assert "beginning" in edge.words
    bare = {name: values for name, values in archive.arrays.items() if name == "label"}
    start = type(archive)(archive.scan, bare).start_of((4, 0), 0, archive.scan.system)
    assert start.state is None
    assert "does not hold" in start.words


def test_a_scan_under_way_ends_as_its_archive(small_map):
    whole = stored(small_map)
    growing = empty(whole.scan)
    assert set(map_view.column(growing, "label").ravel()) == {0}
    computer = Computer(whole.scan, helped=False)
    for block in blocks_of(whole.scan):
        growing.put(block, computer.block(block))
    for name, values in growing.arrays.items():
        np.testing.assert_array_equal(values, whole.arrays[name])


def test_a_long_section_keeps_its_last_states_and_without_one_the_orbit_s_point_is_shown(
    small_map, monkeypatch
):
    archive = stored(small_map)
    monkeypatch.setattr("nlds_vines.explore.map_data.MOST_SECTION", 6 * 4 * 2 * 4 * 5)
    section = archive.arrays["section"]
    np.testing.assert_array_equal(stored(small_map).arrays["section"], section[..., -5:, :])
    arrays = {n: v for n, v in archive.arrays.items() if n != "section"}
    points = section_points(type(archive)(archive.scan, arrays), 12)
    np.testing.assert_array_equal(points[:, 0], archive.lanes("orbit_point").reshape(-1, 4))


def test_any_other_file_is_refused_in_one_line(small_map, tmp_path, error_of):
    path, whole = tmp_path / "other.h5", small_map.read_bytes()
    for content in (b"no archive", whole[: len(whole) // 2], whole):
        path.write_bytes(content)
        if content is whole:
            with h5py.File(path, "a") as file:
                file.attrs["content"] = "tuning"
        assert "other.h5" in error_of(stored, path)


def test_what_maps_and_diagrams_show(small_map, small_diagram):
    names = [show.name for show in map_view.shows_of(stored(small_map))]
    assert names[:3] == ["regimes", "regimes of a start", "coexisting"]
    assert {"share:T,1", "E1max", "lyapunov"} <= set(names)
    # a diagram shows its section first
    shows = map_view.shows_of(stored(small_diagram))
    assert [show.name for show in shows[:2]] == ["x2", "x1"]
    assert shows[0].points
    # colors are those of the pictures
    archive = stored(small_map)
    words = map_view.label_codes(archive)[0][1:]
    shades = colors(words)
    classes = map_view.classes_of(archive)[1:]
    assert [shade for _, shade, _ in classes] == [shades[word] for word in words]
    names = {name: shade for _, shade, name in classes}
    assert len(names) == len(set(names.values()))  # one name for each color


def test_maps_and_diagrams_show_what_is_computed_touches_and_modulation(small_map):
    # a map of sections alone shows what is computed
    archive = stored(small_map)
    arrays = {name: archive.arrays[name].copy() for name in ("section", "status")}
    failed = next(code for code in STATUS if code not in (OK, NOT_COMPUTED))
    arrays["status"][0, 0, 0], arrays["status"][1, 0, 0] = NOT_COMPUTED, failed
    bare = type(archive)(archive.scan, arrays)
    assert [show.name for show in map_view.shows_of(bare)] == ["status"]
    codes = map_view.column(bare, "computed").reshape(6, 4, 2)
    assert (codes[0, 0, 0], codes[1, 0, 0], codes[2, 2, 1]) == (0, 2, 1)
    # a diagram shows the section at impact
    want = {"want": ["section", "impact_section", "regime"]}
    archive = empty(load_scan({**DIAGRAM, "record": want}))
    speeds = archive.arrays["impact_speed"]
    assert speeds.shape == (9, 1, 4 * 30)  # room for four impacts a period
    speeds[...] = np.arange(speeds.size).reshape(speeds.shape)
    shows = {show.name: show for show in map_view.shows_of(archive)}
    assert list(shows)[:4] == ["x2", "x1", "impact_speed", "impact_phase"]
    assert (shows["impact_speed"].points, shows["impact_speed"].unit) == (True, "m/s")
    drawn = map_view.diagram_values(archive, shows["impact_speed"])
    np.testing.assert_array_equal(drawn.ravel(), np.arange(speeds.size))
    assert '"impact_speed"' not in report_page(archive).html  # it holds nothing of touches
    # a map shows the kind of modulation
    twice = {**MAP, "system": "vi-nes", "record": {"want": ["modulation", "impact_section"]}}
    archive = empty(load_scan(twice))
    codes = archive.arrays["capture"]
    codes[...] = np.arange(codes.size).reshape(codes.shape) % 5 - 1
    (show,) = [one for one in map_view.shows_of(archive) if one.name == "capture"]
    words = [word for word, *_ in show.classes]
    assert words[1:] == ["no impacts", "strongly modulated", "sustained 1:1", "more impacts"]
    assert len(words) == len(CAPTURE_FLAGS) + 1
    np.testing.assert_array_equal(
        map_view.column(archive, "capture").ravel(), np.arange(codes.size) % 5
    )
    assert "impact_phase" not in archive.arrays  # a map has no room for touches
