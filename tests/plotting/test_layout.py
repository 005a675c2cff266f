"""Pages: panels of the heights asked for, titles, letters and symbols that hide nothing."""

import pytest
from layout import collisions
from matplotlib.figure import Figure

import nlds_vines as nv
from nlds_vines.model.parameters import setting_in_words
from nlds_vines.model.system import System
from nlds_vines.plotting.page import (
    LETTER_ROOM,
    ONE_COLUMN,
    TWO_COLUMNS,
    add_legend,
    finish,
    new_figure,
    styled,
    write_letters,
    write_out_ticks,
)
from nlds_vines.plotting.style import typeset

TITLE = "SSul NES, Set 6, omega = 6.28 rad/s, P = 800 N, K = 3.25e+07 N/m^1.5: 20 starts"


def made(page, title, entries=3, side="above"):
    """Return a figure of two panels, 1 and 2 inches high, with a legend, and its panels."""
    figure, grid = new_figure(page, [1.0, 2.0])
    panels = [figure.add_subplot(place) for place in grid]
    for number in range(entries):
        panels[0].plot([0, 1000 * number], [0, 1], label=f"curve {number}")
    write_letters(panels)
    place = panels[0] if side == "above" else panels[1]
    add_legend(place, panels[0].get_lines(), side, LETTER_ROOM if side == "above" else 0)
    finish(figure, grid, title)
    return figure, panels


@styled()
@pytest.mark.parametrize("page", [ONE_COLUMN, TWO_COLUMNS])
@pytest.mark.parametrize("side", ["above", "below", "right"])
def test_panels_have_their_heights_and_share_their_edges(page, side):
    figure, panels = made(page, TITLE, 9, side)
    boxes = [axes.get_position() for axes in panels]
    heights = [box.height * figure.get_figheight() for box in boxes]
    assert heights == pytest.approx([1.0, 2.0], abs=0.01)
    assert boxes[0].x0 == pytest.approx(boxes[1].x0)
    assert boxes[0].x1 == pytest.approx(boxes[1].x1)
    assert figure.get_figwidth() == page.width
    assert collisions(figure) == []


@styled()
def test_a_long_title_is_broken_and_the_figure_grows_for_it():
    short, long = made(ONE_COLUMN, "omega = 6 rad/s")[0], made(ONE_COLUMN, TITLE)[0]
    assert "\n" in long.get_suptitle()
    assert long.get_figheight() > short.get_figheight() + 0.1
    assert "\n" not in made(TWO_COLUMNS, TITLE)[0].get_suptitle()


@styled()
@pytest.mark.parametrize("page", [ONE_COLUMN, TWO_COLUMNS])
@pytest.mark.parametrize(
    ("low", "high"),
    [(10, 1e4), (10, 1e5), (2e4, 9e4), (200, 9000), (3e5, 8e5), (0.002, 3), (1e-9, 1e9)],
)
def test_numbers_along_a_logarithmic_axis_have_room_in_the_final_panel(page, low, high):
    figure, grid = new_figure(page, [2.0])
    ends = low * (1 + 1e-15), high
    axes = figure.add_subplot(grid[0], xscale="log", yscale="log", xlim=ends, ylim=ends)
    write_out_ticks(axes.xaxis)
    write_out_ticks(axes.yaxis)
    axes.set_ylabel("three\nlines\nof a label")  # makes the panel narrower than it was
    figure.colorbar(axes.scatter([low, high], [low, high], c=[0, 1]), ax=axes, label="a bar")
    finish(figure, grid, "a title")
    assert collisions(figure) == []
    for ticks in (axes.get_xticks(), axes.get_yticks()):
        assert len(ticks) >= 3
        assert all(0.999 * low <= tick <= 1.001 * high for tick in ticks)


@pytest.mark.parametrize(
    ("plain", "printed"),
    [
        ("K = 2.5e+07 N/m^1.5", r"$K$ = $2.5\times10^{7}$ N/m$^{3/2}$"),
        ("ω = 7.4 rad/s", r"$\omega$ = 7.4 rad/s"),
        ("k2, C tuned for omega = 6.28 rad/s", r"$k_2$, $C$ tuned for $\omega$ = 6.28 rad/s"),
        ("ω, a", r"$\omega$, $a$"),
        ("Bouncing ball: a, e", "Bouncing ball: $a$, $e$"),
        ("a, b of a list: a story", "a, b of a list: a story"),
        ("P from 600 to 1000 N", "$P$ from 600 to 1000 N"),
        ("1e-05 m, g = 9.81 m/s^2", r"$10^{-5}$ m, $g$ = 9.81 m/s$^{2}$"),
        ("a Price of $5, run2e5, E1max, K.", r"a Price of \$5, run2e5, E1max, K."),
    ],
)
def test_titles_are_printed_with_symbols_powers_and_units(plain, printed):
    assert typeset(plain) == printed
    Figure().text(0, 0, typeset(plain)).figure.draw_without_rendering()


def test_a_system_without_a_title_is_not_called_by_its_kind_or_file():
    ssbl = nv.load_system("ssbl")
    plain = System("tmd", dict(nv.load_system("tmd").parameters))
    assert plain.in_words() == "Tuned mass damper"
    of_file = System("ssbl", ssbl.parameters, name="a/b.toml")
    assert of_file.in_words() == "Single-sided bilateral NES"
    limited = System("ssvi-b", ssbl.parameters)
    assert limited.in_words() == "Single-sided NES (ssvi-b)"
    assert System("ssbl", ssbl.parameters, name="mine").in_words() == "mine"
    assert ssbl.in_words() == "SSbl NES"
    assert setting_in_words("K", 2.5e7) == "K = 2.5e+07 N/m^1.5"
