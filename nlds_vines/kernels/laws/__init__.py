"""Contact laws: each one file, which says what is its own; a wall is a tuple of a class there.

    hertz            elastic bodies: force K z^(3/2); short impacts are solved at once
    power            force K z^n, and Hunt and Crossley's damping of it
    linear_contact   a spring and a dashpot: exact, like a flight
    restitution      rigid bodies: impacts at once, sticking

No other module names a law. What a law may say is marked `by_wall`, here or where it is used, and
is chosen by the wall (`by_law`). `SORTS` of a file has a wall for each law of the model that it
knows, with or without damping: kernels look at nothing but its type. What is to be known of a law
before anything is computed is a constant of its file, which `deciding.says` finds:

    LINEAR           its contacts are as exact as flights, whose cells must be so, too; the wall may
                     let go of a damper before it is out, which then flies out
    AT_ONCE          its impacts take no time, and sticking forgets the state
    SHORT_IMPACTS    its contacts may be short impacts, solved on an arc
"""
