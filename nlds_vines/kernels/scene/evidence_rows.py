"""The columns of a verdict's evidence, a row of numbers for each orbit; NaN where one is unknown.

  0 KIND            of `codes`                  8 LYAPUNOV        largest exponent [1/s]
  1 CYCLE_PERIOD    n of nT, 0 if not periodic  9 INTERVAL        half its 99 % interval [1/s]
  2 NEAR_IMPACTS    k at the near wall per nT  10 DIGITS          to which time averages agree
  3 FAR_IMPACTS     k at the far wall per nT   11 SETTLING        period, -1 if it never settles
  4 RESIDUAL        of the orbit, relative     12 WATCHED         periods looked at
  5 RADIUS          largest |multiplier|       13 PASSING         exponent while settling [1/s]
  6 CLEARANCE       nearest miss [m]           14 PASSING_WIDTH   half its 99 % interval [1/s]
  7 SLOWEST         impact [m/s]

  15 EXPONENTS      4 Lyapunov exponents [1/s]; NaN of an nT orbit: ln |mu| / nT from MONODROMY
  19 MONODROMY      16 of the monodromy matrix, column by column
  35 POINT          4 of the periodic orbit's section point (x1, v1, r, s)

Periods count from the beginning of the orbit; the point and the matrix are those of the sections
whose number is a multiple of n.
"""

from __future__ import annotations

KIND, CYCLE_PERIOD, NEAR_IMPACTS, FAR_IMPACTS, RESIDUAL, RADIUS, CLEARANCE, SLOWEST = range(8)
LYAPUNOV, INTERVAL, DIGITS, SETTLING, WATCHED, PASSING, PASSING_WIDTH = range(8, 15)
EXPONENTS, MONODROMY, POINT = 15, 19, 35
LENGTH_OF_ROW = 39
