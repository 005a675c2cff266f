"""Plain text as it is printed in pictures, and titles that nobody wrote."""

import pytest
from matplotlib.figure import Figure

import nlds_vines as nv
from nlds_vines.model.parameters import PARAMETERS, setting_in_words
from nlds_vines.model.system import System, system_in_words
from nlds_vines.plotting.style import axis_label, number_text, raised, setting_label, typeset


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


def test_a_setting_has_a_power_of_ten_and_a_unit():
    assert setting_label("K", 2.5e7) == r"$K=2.5\times10^{7}$ N/m$^{3/2}$"
    assert setting_label("e", 0.7) == "$e=0.7$"
    assert [number_text(value) for value in (0.0, 1e4, -2e-4)] == [
        "0", "10^{4}", r"-2\times10^{-4}"
    ]  # fmt: skip
    assert raised("N/m^1.25") == "N/m$^{1.25}$"


def test_no_axis_is_labeled_by_a_sentence_of_help():
    for name in PARAMETERS:
        label = axis_label(name)
        assert ";" not in label
        assert "e+" not in label
    assert axis_label("C") == "clearance at rest $C$ [m]"


def test_a_system_without_a_title_is_not_called_by_its_kind_or_file():
    ssbl = nv.load_system("ssbl")
    plain = System("tmd", {name: nv.load_system("tmd").parameters[name] for name in TMD})
    assert system_in_words(plain) == "Tuned mass damper"
    assert (
        system_in_words(System("ssbl", ssbl.parameters, name="a/b.toml"))
        == "Single-sided bilateral NES"
    )
    limited = System("ssvi-b", ssbl.parameters)
    assert system_in_words(limited) == "Single-sided NES (ssvi-b)"
    assert system_in_words(System("ssbl", ssbl.parameters, name="mine")) == "mine"
    assert system_in_words(ssbl) == "SSbl NES"
    assert setting_in_words("K", 2.5e7) == "K = 2.5e+07 N/m^1.5"


TMD = ("m1", "k1", "c1", "m2", "k2", "c2", "P", "omega")
