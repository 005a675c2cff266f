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
