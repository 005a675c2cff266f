"""Codes of statuses, events and kinds of verdicts, and columns of records.

Kernels return and store them; `engine.records` and `model.labels` have their words. Archives
hold statuses and kinds, so no number may change its meaning.
"""

from __future__ import annotations

# How the computation of an orbit ended
OK = 0
NOT_COMPUTED = 1  # the fill value of an archive; no kernel returns it
DIVERGED = 2  # the state is not finite or absurdly large (`orbit.HUGE`)
STEP_BUDGET = 3  # a period has too many touches or steps, or a touch could not be told from a miss
BAD_PARAMETERS = 4  # a parameter is not finite or out of range
TOO_STIFF = 5  # a period needs too many cells (`flight.MOST_CELLS`) or more steps than rk4 is given

# How a flight ended
SECTION = 0  # at the section that it was to fly to
TOUCH_NEAR = 1  # at a touch of the near wall
TOUCH_FAR = 2  # at a touch of the far wall
ASTRAY = 3  # a touch could not be told from a miss

# Modes of an orbit: FLYING, TOUCH_NEAR or TOUCH_FAR in a contact, or leaving the place of a contact
# after its force has vanished (`linear_contact.leave`)
FLYING = 0
LEAVING_NEAR = 4
LEAVING_FAR = 5

# How leaving ended, unless at the section
RETURNED = 6  # the wall pushes again
CLEARED = 7  # the damper is out

# How a contact ended
RELEASED = 0  # the damper left the wall
STOPPED = 1  # the time was over first
EXHAUSTED = 2  # too many steps

# Kinds of verdicts
UNDETERMINED = 0
PERIODIC = 1
QUASIPERIODIC = 2
CHAOTIC = 3
TRANSIENT_CHAOS = 4  # periodic in the end, chaotic for long before
FAILED = 5  # not computed to its end; no kernel returns it

# Columns of a response: the maximum and the rms of x1, v1, a1, r and x1 + y, a1 being the absolute
# acceleration and y the displacement of a moving ground; the largest force and the largest impulse
# at the near and the far wall; the mean powers [W] that c1, c2 and contacts dissipate, and that
# comes in
OF_FORCES = 10
OF_IMPULSES = 12
POWERS = 14
RESPONSE_COLUMNS = 18

# Columns of a touch: the wall, 0 near, 1 far; the phase of the forcing [turns]; the speed [m/s]
AT_WALL, AT_PHASE, AT_SPEED = 0, 1, 2
TOUCH_COLUMNS = 3


# --------------------------------------------------------------------------------------------------
# The columns of a verdict's evidence, a row of numbers for each orbit; NaN where one is unknown.
#
#   0 KIND            UNDETERMINED ...            8 LYAPUNOV        largest exponent [1/s]
#   1 CYCLE_PERIOD    n of nT, 0 if not periodic  9 INTERVAL        half its 99 % interval [1/s]
#   2 NEAR_IMPACTS    k at the near wall per nT  10 DIGITS          to which time averages agree
#   3 FAR_IMPACTS     k at the far wall per nT   11 SETTLING        period, -1 if it never settles
#   4 RESIDUAL        of the orbit, relative     12 WATCHED         number of analyzed periods
#   5 RADIUS          largest |multiplier|       13 PASSING         exponent while settling [1/s]
#   6 CLEARANCE       nearest miss [m]           14 PASSING_WIDTH   half its 99 % interval [1/s]
#   7 SLOWEST         impact [m/s]
#
#   15 EXPONENTS      4 Lyapunov exponents [1/s]; NaN of an nT orbit: ln |mu| / nT from MONODROMY
#   19 MONODROMY      16 of the monodromy matrix, column by column
#   35 POINT          4 of the periodic orbit's section point (x1, v1, r, s)
#
# Periods count from the beginning of the orbit; the point and the matrix are those of the sections
# whose number is a multiple of n.


KIND, CYCLE_PERIOD, NEAR_IMPACTS, FAR_IMPACTS, RESIDUAL, RADIUS, CLEARANCE, SLOWEST = range(8)
LYAPUNOV, INTERVAL, DIGITS, SETTLING, WATCHED, PASSING, PASSING_WIDTH = range(8, 15)
EXPONENTS, MONODROMY, POINT = 15, 19, 35
LENGTH_OF_ROW = 39
