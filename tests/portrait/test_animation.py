"""Films of an orbit: what stands where in a frame, how many there are, what is refused."""

import numpy as np
import pytest
from matplotlib.patches import Rectangle
from PIL import Image

import nlds_vines as nv
from nlds_vines.errors import RequestError
from nlds_vines.model.system import System
from nlds_vines.orbits.impact_rows import IMPACT
from nlds_vines.orbits.spectrum import spectrum_of
from nlds_vines.portrait import animation
from nlds_vines.portrait.picture import OBSTACLE
from nlds_vines.portrait.request import Column, Window
from nlds_vines.portrait.request_file import load_portrait
from nlds_vines.portrait.window_view import View

SAMPLES, PERIODS = 48, 2
NONE = nv.load_system("none", omega=7.0)
PASSING = System("ssvi-c", {**nv.load_system("ssbl").parameters, "L": 0.1})


def view_of(system, u, touch=0.5):
    """Return a made-up window in which the damper strikes once, `touch` periods after its begin."""
    turns = np.arange(1, SAMPLES * PERIODS + 1) / SAMPLES
    states = np.zeros((turns.size, 4 if system.scene.damper else 2))
    states[:, 0] = 0.1 * np.sin(2 * np.pi * turns)
    if system.scene.damper:
        states[:, 2] = states[:, 0] + u
    impacts = np.zeros(1, IMPACT)
    impacts["touch"] = touch * system.period
    spectrum = spectrum_of(states[:, 0], SAMPLES, system.parameters["omega"])
    window = Column(system, Window(0, PERIODS), "")
    return View(window, turns * system.period, states, SAMPLES, impacts, 1, 1e-6, 1, 1, spectrum)


def boxes(figure):
    """Return (left edge, right edge) of structure, post and damper."""
    found = [item for item in figure.axes[0].patches if isinstance(item, Rectangle)]
    return [(box.get_x(), box.get_x() + box.get_width()) for box in found]


@pytest.mark.parametrize(
    ("system", "side"), [(nv.load_system("ssul-set6"), "left"), (PASSING, "right")]
)
def test_the_damper_touches_its_obstacle_where_the_orbit_does(system, side):
    obstacle = float(system.scene.obstacle(system.parameters)["obstacle"])
    u = obstacle + (0.2 if side == "left" else -0.2) * np.abs(
        np.sin(2 * np.pi * np.arange(1, SAMPLES * PERIODS + 1) / SAMPLES)
    )
    view = view_of(system, u)
    figure, update = animation._stage("a film", view, PERIODS)
    for frame in (0, 12, 24):
        update(frame)
        place = round(frame * SAMPLES / animation.FRAMES)
        *_, (left, right) = boxes(figure)
        face = {"left": left, "right": right}[side]
        walls = [line for line in figure.axes[0].lines if line.get_color() == OBSTACLE]
        gap = face - walls[-1].get_xdata()[0]
        assert gap == pytest.approx(u[place] - obstacle, abs=1e-12)
        wall = walls[-1]
        assert (wall.get_linewidth() > 3) == (frame == 12)  # it was struck half a period after 0


def test_between_two_walls_the_damper_has_room_for_its_width():
    system = nv.load_system("ssbl")
    walls = system.scene.obstacle(system.parameters)
    u = np.linspace(float(walls["structure"]), float(walls["obstacle"]), SAMPLES * PERIODS)
    view = view_of(system, u)
    figure, update = animation._stage("a film", view, PERIODS)
    update(0)
    _, (_, post), (left, _) = boxes(figure)
    assert left == pytest.approx(post, abs=0.02)
    assert left >= post - 1e-12


def test_a_film_has_a_second_for_each_period_and_is_whole(tmp_path):
    view = view_of(NONE, 0.0)
    request = load_portrait(NONE, {"portrait": {"show": 1}})
    path = animation.save_film(request, view, tmp_path / "orbit.gif")
    with Image.open(path) as film:
        assert film.n_frames == animation.FRAMES
        assert film.size == (800, 450)
        assert film.info["duration"] in (40, 41, 42)
    assert [item.name for item in tmp_path.iterdir()] == ["orbit.gif"]


def test_films_that_cannot_be_made_are_one_line_and_nothing_is_written(
    tmp_path, monkeypatch, refusal
):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(animation.films.writers, "is_available", lambda name: name == "pillow")
    for name, words in (
        ("a.avi", "a film is one of .gif, .mp4"),
        ("a.mp4", "needs the program ffmpeg, which is not here; take a .gif"),
        ("no/a.gif", "there is no folder"),
    ):
        error = refusal("portrait", "--animate", name)
        assert words in error
        assert error.count("\n") == 1
    (tmp_path / "mine.gif").write_text("notes")
    assert "mine.gif" in refusal("portrait", "--animate", "mine.gif")
    assert [item.name for item in tmp_path.iterdir()] == ["mine.gif"]
    with pytest.raises(RequestError, match="a film is one of"):
        animation.check_film(tmp_path / "a.png")
