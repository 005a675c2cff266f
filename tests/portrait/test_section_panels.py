"""Sections in planes of their own: which states and touches they show, and how many overlap."""

import numpy as np
import pytest

import nlds_vines as nv
from nlds_vines.errors import RequestError
from nlds_vines.portrait.picture import CROWDED
from nlds_vines.portrait.picture import portrait as draw
from nlds_vines.portrait.request import load_portrait
from nlds_vines.portrait.run import views_of

SAMPLING = {"transient": 300, "periods": 24, "samples": 64}


def page(system, panels, sampling=SAMPLING, **portrait):
    request = load_portrait(
        system, {"sampling": sampling, "portrait": {"panels": panels, **portrait}}
    )
    (view,) = views_of(request)
    return draw(request, [view]), view


def drawn(axes, label):
    (line,) = (line for line in axes.lines if line.get_label() == label)
    return line.get_xydata()


@pytest.mark.kernels
@pytest.mark.parametrize(("phase", "sample"), [(0.0, 0), (0.25, 16), (0.499, 32), (1.0, 0)])
def test_a_section_is_taken_at_any_phase_of_the_force(phase, sample):
    figure, view = page("tmd", ["section", "section1"], section_phase=phase)
    system = view.column.system
    time = view.time[(sample - 1) % 64]
    assert np.cos(system.parameters["omega"] * time) == pytest.approx(
        np.cos(2 * np.pi * sample / 64), abs=1e-9
    )
    label = "$t=nT$" if sample == 0 else rf"$\phi={sample / 64:.3g}$"
    state = view.states[(sample - 1) % 64 :: 64][-1]
    damper, structure = figure.axes
    assert drawn(damper, label).tolist() == [state[2:].tolist()]
    assert drawn(structure, label).tolist() == [state[:2].tolist()]
    assert (damper.get_xlabel(), structure.get_xlabel()) == ("$x_2$ [m]", "$x_1$ [m]")


@pytest.mark.kernels
def test_the_section_at_impact_has_phase_and_speed_of_a_cycle_by_wall():
    figure, view = page(nv.load_system("ssbl", omega=6.05), ["impact-section"])
    (axes,) = figure.axes
    assert view.label == "T,2"
    period = view.column.system.period
    for name in ("obstacle", "structure"):
        row = view.contacts[view.contacts["wall"] == name][-1]
        (point,) = drawn(axes, name)
        assert point == pytest.approx([row["touch"] / period % 1.0 * 2 * np.pi, row["speed"]])
    assert axes.get_xlim() == (0.0, 2 * np.pi)
    assert axes.get_ylim()[1] > view.contacts["speed"].max()


@pytest.mark.kernels
def test_of_many_points_the_color_tells_how_many_are_near():
    chaos = nv.load_system("ssul-set6", omega=7.4, K=2.5e7)
    long = {"transient": 400, "periods": CROWDED, "samples": 16}
    figure, _ = page(chaos, ["section"], long)
    (cloud,) = figure.axes[0].collections
    assert len(cloud.get_offsets()) == CROWDED
    near = np.asarray(cloud.get_array())
    assert near.min() == 1
    assert near.max() > 5
    assert (np.diff(near) >= 0).all()  # the dense ones above
    few, _ = page(chaos, ["section"], {**long, "periods": CROWDED - 1})
    assert not few.axes[0].collections


def test_a_scene_without_walls_has_no_section_at_impact():
    with pytest.raises(RequestError, match="cannot be filled for kind 'tmd'"):
        load_portrait("tmd", {"portrait": {"panels": ["impact-section"]}})


def test_the_phase_of_a_section_is_of_the_hash_where_it_is_not_zero():
    plain = load_portrait("ssul-set6")
    assert load_portrait("ssul-set6", {"portrait": {"section_phase": 0.0}}).hash == plain.hash
    turned = load_portrait("ssul-set6", {"portrait": {"section_phase": 0.25}})
    assert turned.hash != plain.hash
    assert load_portrait(turned.document()).section_phase == 0.25
