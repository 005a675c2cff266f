"""One step of the regularised contact: order eight (Dormand and Prince) and classical order four.

The stages are written out: a loop over a tableau is about ten times slower. Stage i starts from
row Y plus h times the slopes of the stages before it, with weights Ai_1, Ai_2, ...; the step adds
the slopes of all with weights B1, B2, ... Coefficients of order eight: Hairer, Norsett, Wanner,
Solving Ordinary Differential Equations I (1993), DOP853.
"""

from __future__ import annotations

from ..numerics.compiling import jit
from ..numerics.deciding import is_a
from ..scene.arguments import Step
from .contact_field import slope
from .driven import count_of
from .response_sums import Tally

# The scratch array k of a contact: 16 rows of 24 numbers, each row a state or its slope; AHEAD,
# what is ahead of an orbit inside an impact that is solved (`inside.Ahead`); SECOND, what becomes
# of variations there (`inside_variations.vary_cut`); and SHRUNK, the logarithm by which contacts
# have shrunk volumes of variations.
#
#   row      0: Y        1: NEW      2: STAGE        3: SAVE          4 ... 15: K1 ... K12
#            before      after       within a step   one to keep      slopes of the stages
#
#   in a row   0  1  2   3   4    5      6      7     8      9 ...        20   21 ... 23
#              q  s  x1  v1  tau  (x1    v1     r     s)     (...) (...) (...)  balances
#                                  four variations, where they are wanted         (of slopes alone)
#   (the last three: WORK, VIRIAL, DRAIN of `contact_field`)
#
# A name is the place of a row's first number, so that k[NEW + 1] is s after a step.
WIDTH = 5  # numbers of a state: q, s, x1, v1, tau
ROW = 24  # distance of the rows
Y, NEW, STAGE, SAVE = 0, ROW, 2 * ROW, 3 * ROW
K1, K2, K3, K4, K5, K6, K7, K8, K9, K10, K11, K12 = (ROW * (4 + i) for i in range(12))
AHEAD = ROW * 16
SECOND = AHEAD + 9
SHRUNK = SECOND + 20
SCRATCH = SHRUNK + 1

A2_1 = 0.05260015195876773
A3_1 = 0.0197250569845379
A3_2 = 0.0591751709536137
A4_1 = 0.02958758547680685
A4_3 = 0.08876275643042054
A5_1 = 0.2413651341592667
A5_3 = -0.8845494793282861
A5_4 = 0.924834003261792
A6_1 = 0.037037037037037035
A6_4 = 0.17082860872947386
A6_5 = 0.12546768756682242
A7_1 = 0.037109375
A7_4 = 0.17025221101954405
A7_5 = 0.06021653898045596
A7_6 = -0.017578125
A8_1 = 0.03709200011850479
A8_4 = 0.17038392571223998
A8_5 = 0.10726203044637328
A8_6 = -0.015319437748624402
A8_7 = 0.008273789163814023
A9_1 = 0.6241109587160757
A9_4 = -3.3608926294469414
A9_5 = -0.868219346841726
A9_6 = 27.59209969944671
A9_7 = 20.154067550477894
A9_8 = -43.48988418106996
A10_1 = 0.47766253643826434
A10_4 = -2.4881146199716677
A10_5 = -0.590290826836843
A10_6 = 21.230051448181193
A10_7 = 15.279233632882423
A10_8 = -33.28821096898486
A10_9 = -0.020331201708508627
A11_1 = -0.9371424300859873
A11_4 = 5.186372428844064
A11_5 = 1.0914373489967295
A11_6 = -8.149787010746927
A11_7 = -18.52006565999696
A11_8 = 22.739487099350505
A11_9 = 2.4936055526796523
A11_10 = -3.0467644718982196
A12_1 = 2.273310147516538
A12_4 = -10.53449546673725
A12_5 = -2.0008720582248625
A12_6 = -17.9589318631188
A12_7 = 27.94888452941996
A12_8 = -2.8589982771350235
A12_9 = -8.87285693353063
A12_10 = 12.360567175794303
A12_11 = 0.6433927460157636
B1 = 0.054293734116568765
B6 = 4.450312892752409
B7 = 1.8915178993145003
B8 = -5.801203960010585
B9 = 0.3111643669578199
B10 = -0.1521609496625161
B11 = 0.20136540080403034
B12 = 0.04471061572777259


@jit
def width_of(tangent):
    """Return how many numbers of a row are in use: of plain variations a constant of the code."""
    if tangent is None or is_a(tangent, Tally):
        return WIDTH
    return WIDTH + count_of(tangent)


@jit
def eighth(side, tangent, step):
    """Advance row Y by a step of order eight and write row NEW."""
    # int() keeps each row from being compiled on its own
    k, h = side.k, step.h
    # Stage 1: the slope at row Y.
    slope(side, tangent, step, int(Y), int(K1))
    # Stage 2.
    for i in range(width_of(tangent)):
        k[STAGE + i] = k[i] + h * (A2_1 * k[K1 + i])
    slope(side, tangent, step, int(STAGE), int(K2))
    # Stage 3.
    for i in range(width_of(tangent)):
        k[STAGE + i] = k[i] + h * (A3_1 * k[K1 + i] + A3_2 * k[K2 + i])
    slope(side, tangent, step, int(STAGE), int(K3))
    # Stage 4.
    for i in range(width_of(tangent)):
        k[STAGE + i] = k[i] + h * (A4_1 * k[K1 + i] + A4_3 * k[K3 + i])
    slope(side, tangent, step, int(STAGE), int(K4))
    # Stage 5.
    for i in range(width_of(tangent)):
        k[STAGE + i] = k[i] + h * (A5_1 * k[K1 + i] + A5_3 * k[K3 + i] + A5_4 * k[K4 + i])
    slope(side, tangent, step, int(STAGE), int(K5))
    # Stage 6.
    for i in range(width_of(tangent)):
        k[STAGE + i] = k[i] + h * (A6_1 * k[K1 + i] + A6_4 * k[K4 + i] + A6_5 * k[K5 + i])
    slope(side, tangent, step, int(STAGE), int(K6))
    # Stage 7.
    for i in range(width_of(tangent)):
        k[STAGE + i] = k[i] + h * (
            A7_1 * k[K1 + i] + A7_4 * k[K4 + i] + A7_5 * k[K5 + i] + A7_6 * k[K6 + i]
        )
    slope(side, tangent, step, int(STAGE), int(K7))
    # Stage 8.
    for i in range(width_of(tangent)):
        k[STAGE + i] = k[i] + h * (
            A8_1 * k[K1 + i]
            + A8_4 * k[K4 + i]
            + A8_5 * k[K5 + i]
            + A8_6 * k[K6 + i]
            + A8_7 * k[K7 + i]
        )
    slope(side, tangent, step, int(STAGE), int(K8))
    # Stage 9.
    for i in range(width_of(tangent)):
        k[STAGE + i] = k[i] + h * (
            A9_1 * k[K1 + i]
            + A9_4 * k[K4 + i]
            + A9_5 * k[K5 + i]
            + A9_6 * k[K6 + i]
            + A9_7 * k[K7 + i]
            + A9_8 * k[K8 + i]
        )
    slope(side, tangent, step, int(STAGE), int(K9))
    # Stage 10.
    for i in range(width_of(tangent)):
        k[STAGE + i] = k[i] + h * (
            A10_1 * k[K1 + i]
            + A10_4 * k[K4 + i]
            + A10_5 * k[K5 + i]
            + A10_6 * k[K6 + i]
            + A10_7 * k[K7 + i]
            + A10_8 * k[K8 + i]
            + A10_9 * k[K9 + i]
        )
    slope(side, tangent, step, int(STAGE), int(K10))
    # Stage 11.
    for i in range(width_of(tangent)):
        k[STAGE + i] = k[i] + h * (
            A11_1 * k[K1 + i]
            + A11_4 * k[K4 + i]
            + A11_5 * k[K5 + i]
            + A11_6 * k[K6 + i]
            + A11_7 * k[K7 + i]
            + A11_8 * k[K8 + i]
            + A11_9 * k[K9 + i]
            + A11_10 * k[K10 + i]
        )
    slope(side, tangent, step, int(STAGE), int(K11))
    # Stage 12.
    for i in range(width_of(tangent)):
        k[STAGE + i] = k[i] + h * (
            A12_1 * k[K1 + i]
            + A12_4 * k[K4 + i]
            + A12_5 * k[K5 + i]
            + A12_6 * k[K6 + i]
            + A12_7 * k[K7 + i]
            + A12_8 * k[K8 + i]
            + A12_9 * k[K9 + i]
            + A12_10 * k[K10 + i]
            + A12_11 * k[K11 + i]
        )
    slope(side, tangent, step, int(STAGE), int(K12))
    # The step itself.
    for i in range(width_of(tangent)):
        k[NEW + i] = k[i] + h * (
            B1 * k[K1 + i]
            + B6 * k[K6 + i]
            + B7 * k[K7 + i]
            + B8 * k[K8 + i]
            + B9 * k[K9 + i]
            + B10 * k[K10 + i]
            + B11 * k[K11 + i]
            + B12 * k[K12 + i]
        )


@jit
def mean_slope(k, i):
    """Return the mean of the slopes at place i of their rows over the step of order eight."""
    first = B1 * k[K1 + i] + B6 * k[K6 + i] + B7 * k[K7 + i] + B8 * k[K8 + i]
    return first + (B9 * k[K9 + i] + B10 * k[K10 + i] + B11 * k[K11 + i] + B12 * k[K12 + i])


@jit
def mean_of(rk4, k, i):
    """Return the mean of the slopes at place i of their rows by the order of the method."""
    if rk4 is None:
        return mean_slope(k, i)
    return (k[K1 + i] + 2.0 * (k[K2 + i] + k[K3 + i]) + k[K4 + i]) / 6.0


@jit
def fourth(side, tangent, step):
    """Advance row Y by a classical Runge-Kutta step of order four and write row NEW."""
    k, h = side.k, step.h
    slope(side, tangent, step, int(Y), int(K1))
    for i in range(width_of(tangent)):
        k[STAGE + i] = k[i] + 0.5 * h * k[K1 + i]
    slope(side, tangent, step, int(STAGE), int(K2))
    for i in range(width_of(tangent)):
        k[STAGE + i] = k[i] + 0.5 * h * k[K2 + i]
    slope(side, tangent, step, int(STAGE), int(K3))
    for i in range(width_of(tangent)):
        k[STAGE + i] = k[i] + h * k[K3 + i]
    slope(side, tangent, step, int(STAGE), int(K4))
    for i in range(width_of(tangent)):
        k[NEW + i] = k[i] + h / 6.0 * (k[K1 + i] + 2.0 * (k[K2 + i] + k[K3 + i]) + k[K4 + i])


@jit
def advance(side, tangent, step):
    """Advance row Y by a `Step`, of the method's order: four of rk4, otherwise eight.

    tangent: what goes along, as in `contact_field.slope`.
    """
    if side.rk4 is None:
        eighth(side, tangent, step)
    else:
        fourth(side, tangent, step)


@jit
def part_of(step, x):
    """Return the part x of a step, from 0 to 1."""
    return Step(step.phase, step.landing, x * step.h)


@jit
def save(k):
    """Keep row NEW in row SAVE."""
    for i in range(WIDTH):
        k[SAVE + i] = k[NEW + i]


@jit
def restore(k):
    """Write what was kept into row NEW again."""
    for i in range(WIDTH):
        k[NEW + i] = k[SAVE + i]
