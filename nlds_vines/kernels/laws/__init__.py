"""Contact laws: one file each, with a tuple for its walls and the kernels in which it differs.

    hertz            elastic bodies: force K z^(3/2); short impacts are solved at once
    power            force K z^n, and Hunt and Crossley's damping of it
    linear_contact   a spring and a dashpot: exact, like a flight
    restitution      rigid bodies: impacts at once, sticking

No other module names a law. The kernels that a law may replace are marked `by_wall` and chosen by
the type of the wall (`by_law`). `SORTS` of a file has a wall, of which only the type matters, for
each law of the model in it, with or without damping. Properties that decide how other kernels are
compiled are constants of the file, which `deciding.says` finds:

    LINEAR           contacts are exact like flights, and need short cells; the wall may let go of a
                     damper that is still beyond the place of touch
    AT_ONCE          impacts take no time, and sticking loses directions of the state
    SHORT_IMPACTS    contacts may be short impacts, solved on an arc
"""
