"""Requests in layers: which layer counts, and the place that every message names."""

import pytest

from nlds_vines.errors import RequestError, whole
from nlds_vines.model.request_layers import Form, Layer, Layers, unchecked

FORM = Form(
    kind="test",
    tables={
        "set": None,
        "sampling": {"periods": lambda value: whole("periods", value, 1), "method": unchecked},
    },
    lists=("column",),
)


def layers(below, above):
    return Layers.of(FORM, FORM.open(below), above, "command line")


def test_the_upper_layer_overrides_entry_by_entry():
    both = layers({"sampling": {"periods": 1, "method": "a"}}, {"sampling": {"periods": 2}})
    assert both.values("sampling") == {"periods": 2, "method": "a"}
    assert both.table("set") == {}
    assert both.holder("sampling") is both.above
    assert both.holder("set") is both.below  # none has it


def test_a_path_a_system_and_a_name_are_sources(tmp_path):
    path = tmp_path / "a.toml"
    path.write_text('title = "of a file"\n')
    assert FORM.open(path).document == FORM.open(str(path)).document == {"title": "of a file"}
    system = FORM.open("tmd").document["system"]
    assert FORM.open(system).document == {"system": system}
    with pytest.raises(RequestError, match="test = 3 must be a path, a name, a table or a System"):
        FORM.open(3)
    with pytest.raises(RequestError, match="must be a file"):
        Form("test", {}, names=False, sources="a file").open(system)


def test_the_system_is_that_of_the_upper_layer_that_names_one():
    assert layers({"system": "tmd"}, {"system": "ssbl"}).system().kind == "ssbl"
    assert layers({"system": "tmd"}, {}).system().kind == "tmd"
    assert layers({}, {}).system_as_set("none").kind == "none"
    with pytest.raises(RequestError, match=r"^test: no system"):
        layers({}, {}).system()


def test_a_title_ends_with_what_it_describes():
    below = {"title": "below"}
    assert layers(below, {"title": "above"}).title(()) == "above"
    assert layers(below, {"set": {"P": 1.0}}).title(("system",)) == "below"
    assert layers(below, {"set": {}}).title(("system", "set")) == "below"
    assert layers(below, {"set": {"P": 1.0}}).title(("system", "set")) is None
    with pytest.raises(RequestError, match=r"^command line: title = 3"):
        layers(below, {"title": 3}).title(())


def test_places_name_layer_and_table():
    layer = Layer(FORM, "a.toml", {})
    assert layer.place("set") == "a.toml: [set]"
    assert layers({}, {"set": {"P": 1.0}}).place("set") == "command line: [set]"
