"""Axes of the frequency in Hz, or over that of the structure: ticks and labels, nothing else."""

from math import pi, sqrt

import numpy as np
import pytest
from matplotlib.axes import Axes

import nlds_vines as nv
from nlds_vines.errors import RequestError

DIAGRAM = {"omega": {"start": 5.5, "stop": 7.0, "num": 4}}
SHORT = {"transient": 10, "periods": 8}
RECORD = {"want": ["section", "impacts", "energy", "regime"]}


@pytest.fixture(scope="module")
def diagram(tmp_path_factory):
    path = tmp_path_factory.mktemp("axis") / "diagram.h5"
    nv.scan("ssul-set6", vary=DIAGRAM, sampling=SHORT, record=RECORD, to=path, quiet=True)
    return path


def labeled(figure) -> Axes:
    (axis,) = (frame for frame in figure.axes if frame.get_xlabel())
    figure.canvas.draw()
    return axis


@pytest.mark.parametrize(
    ("unit", "factor", "words"),
    [
        ("Hz", 1 / (2 * pi), "frequency of the force $f$ [Hz]"),
        ("ratio", 1 / sqrt(39.5), r"frequency ratio $\omega/\omega_0$"),
    ],
)
def test_ticks_stand_at_round_numbers_of_the_unit(diagram, unit, factor, words):
    usual = labeled(nv.plot(diagram))
    frame = labeled(nv.plot(diagram, frequency=unit))
    assert frame.get_xlabel() == words
    assert frame.get_xlim() == usual.get_xlim()  # what is drawn stays
    low, high = frame.get_xlim()
    shown = [tick for tick in frame.get_xticks() if low <= tick <= high]
    assert len(shown) >= 3
    texts = [frame.xaxis.get_major_formatter()(tick) for tick in shown]
    assert np.array(texts, float) == pytest.approx(factor * np.array(shown), rel=1e-5)
    assert all(len(text) <= 5 for text in texts)


def test_panels_above_have_their_ticks_at_the_same_places(diagram):
    figure = nv.plot(diagram, frequency="Hz")
    figure.canvas.draw()
    places = [tuple(f.get_xticks()) for f in figure.axes if f.lines and len(f.get_xticks())]
    assert len(set(places)) == 1


def test_what_has_no_such_axis_is_refused(diagram, tmp_path):
    with pytest.raises(RequestError, match="frequency 'kHz'"):
        nv.plot(diagram, frequency="kHz")
    path = tmp_path / "stiff.h5"
    along = {"k1": {"values": [3.9e4, 4e4]}}
    nv.scan("ssul-set6", vary=along, sampling=SHORT, record=RECORD, to=path, quiet=True)
    with pytest.raises(RequestError, match="no axis of the frequency"):
        nv.plot(path, frequency="Hz")
    with pytest.raises(RequestError, match="needs one frequency"):
        nv.plot(path, frequency="ratio")


def test_a_frequency_that_is_stated_in_hz_is_drawn_and_told_in_hz(tmp_path):
    """The request keeps f, from which the bits of omega follow again."""
    path, vary = tmp_path / "hertz.h5", {"f": {"start": 0.9, "stop": 1.1, "num": 4}}
    nv.scan("ssul-set6", vary=vary, sampling=SHORT, record=RECORD, to=path, quiet=True)
    archive = nv.open_archive(path)
    (axis,) = archive.request.axes
    np.testing.assert_array_equal(axis.values, 2 * pi * np.linspace(0.9, 1.1, 4))
    assert axis.heading().startswith("f = 0.9 to 1.1 Hz (5.655 to 6.912 rad/s)")
    assert archive.request.document()["vary"] == {"f": {"values": axis.stated.values.tolist()}}
    assert archive.request.title.endswith(": f")
    assert labeled(nv.plot(path)).get_xlabel() == "frequency of the force $f$ [Hz]"
    assert labeled(archive.plot()).get_xlabel() == "frequency of the force $f$ [Hz]"
    assert "rad/s" in labeled(nv.plot(path, frequency="rad/s")).get_xlabel()


def test_every_drawing_command_has_a_unit_of_the_frequency(here, ask, refusal, monkeypatch):
    from nlds_vines.plotting import chosen_panels

    drawn = []
    monkeypatch.setattr(chosen_panels, "save_figure", lambda figure, *_: drawn.append(figure))
    words = ["--transient", "10", "--periods", "8", "--quiet", "--plot", "a.png"]
    ask("bifurcation", "--vary", "omega=5.5:7:4", *words, "--frequency", "Hz")
    assert labeled(drawn.pop()).get_xlabel() == "frequency of the force $f$ [Hz]"
    for name in ("bifurcation", "response-curves", "continuation", "tuning", "transients",
                 "response-history --impulse 1", "portrait"):  # fmt: skip
        assert "kHz" in refusal(*name.split(), "--frequency", "kHz")
    for name in ("explore", "report"):
        assert "kHz" in refusal(name, next(here.glob("*.h5")), "--frequency", "kHz")


def test_a_logarithmic_axis_has_round_numbers_of_hz(tmp_path):
    path = tmp_path / "log.h5"
    vary = {"f": {"start": 0.5, "stop": 5.0, "num": 4, "scale": "log"}}
    nv.scan("ssul-set6", vary=vary, sampling=SHORT, record=RECORD, to=path, quiet=True)
    frame = labeled(nv.plot(path))
    if frame.get_xscale() == "log":
        places = np.array(frame.get_xticks()) / (2 * pi)
        assert {1.0, 2.0} <= {*np.round(places, 9)}
