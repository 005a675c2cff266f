"""Colors of regimes that readers with and without all three kinds of cones tell apart, measured.

Colors are seen through the matrices of Machado, Oliveira and Fernandes (2009), severity 1, and
compared by their distance in CIELAB (CIE 1976), of which some 2.3 can just be seen.
"""

from itertools import combinations, product

import numpy as np
import pytest

from nlds_vines.plotting.palette import HATCHED, OTHERS, RAMP, color_of

SIGHT = {
    "all cones": np.eye(3),
    "protanopia": np.array(
        [[0.152286, 1.052583, -0.204868], [0.114503, 0.786281, 0.099216],
         [-0.003882, -0.048116, 1.051998]]
    ),
    "deuteranopia": np.array(
        [[0.367322, 0.860646, -0.227968], [0.280085, 0.672501, 0.047413],
         [-0.011820, 0.042940, 0.968881]]
    ),
    "tritanopia": np.array(
        [[1.255528, -0.076749, -0.178779], [-0.078411, 0.930809, 0.147602],
         [0.004733, 0.691367, 0.303900]]
    ),
}  # fmt: skip
TO_XYZ = np.array(
    [[0.4124564, 0.3575761, 0.1804375], [0.2126729, 0.7151522, 0.0721750],
     [0.0193339, 0.1191920, 0.9503041]]
)  # fmt: skip
WHITE = TO_XYZ.sum(axis=1)
LEAST = 12.0

PLAIN = [f"{n}T,{n}" if n > 1 else "T,1" for n in range(1, len(RAMP) + 1)]
TINTS = [
    f"{n}T,{k}" if n > 1 else f"T,{k}" for n in range(1, len(RAMP)) for k in range(2 * n + 1)
] + PLAIN[-1:]


def seen(color, sight):
    """Return a color `#rrggbb` in CIELAB, as it is seen through a matrix."""
    channels = np.array([int(color[i : i + 2], 16) for i in (1, 3, 5)]) / 255
    linear = np.where(channels <= 0.04045, channels / 12.92, ((channels + 0.055) / 1.055) ** 2.4)
    ratio = TO_XYZ @ np.clip(sight @ linear, 0, 1) / WHITE
    x, y, z = np.where(ratio > 216 / 24389, np.cbrt(ratio), (24389 / 27 * ratio + 16) / 116)
    return np.array([116 * y - 16, 500 * (x - y), 200 * (y - z)])


def test_the_measure_has_the_known_values_of_white_and_of_red():
    assert seen("#ffffff", np.eye(3)) == pytest.approx([100, 0, 0], abs=1e-9)
    assert seen("#ff0000", np.eye(3)) == pytest.approx([53.24, 80.09, 67.20], abs=0.01)


@pytest.mark.parametrize("sight", SIGHT)
def test_regimes_are_told_apart_by_their_colors_and_longer_periods_are_lighter(sight):
    lab = {word: seen(color_of(word), SIGHT[sight]) for word in [*PLAIN, *OTHERS, *TINTS]}
    # periods and what is not periodic, each beside all others; what is not periodic beside tints
    for one, other in (*combinations([*PLAIN, *OTHERS], 2), *product(OTHERS, TINTS)):
        # what is undetermined is hatched beside its color, and closer to a tint without blue
        closer = sight == "tritanopia" and one == HATCHED and other in {*TINTS} - {*PLAIN}
        assert np.linalg.norm(lab[one] - lab[other]) > (8.0 if closer else LEAST), (one, other)
    # longer periods are lighter
    lightness = [seen(color, SIGHT[sight])[0] for color in RAMP]
    assert min(np.diff(lightness)) > 3.0
