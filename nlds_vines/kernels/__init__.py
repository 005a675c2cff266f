"""Compiled numerics: flight, touch, contact, orbit. No I/O, no plotting.

In reading order, each package importing only from those above it:

    numerics   the compilation and storage of kernels, and shared arithmetic
    scene      the parts of a cell: bodies, walls and their law, force
    motion     the linear motion between events, its variations, and the equation of a contact
    watch      records of a piece of motion: touches, largest energies, a limit, a response
    events     from one event to the next: a flight to a touch, a contact to its release
    impact     a short impact, solved at once
    laws       contact laws, one file each
    orbit      the time loop, the map from section to section, and its derivative
    hosts      orbits of any number of degrees of freedom, dampers and walls
    cells      cells of a map: verdicts, branches, basins, many cells one after another

Words:

    cell (of a map)   one set of parameters; in `flight`, a cell is a piece of a forcing period
    chain, link       a sweep of cells, each of which starts from the last state of the one before,
                      and one cell of it
    lane              a chain, which is computed independently of others
    period            one of the forcing, T = 2 pi / omega
    section           the states at the ends of the periods, or `stops` of them in each period
    record, evidence  the section of an orbit to be classified, and the numbers of its verdict
    variations        four small differences from an orbit; they obey the linearized equation

Letters:

    ps, damper, wall      the constants of the structure, of the damper, of one wall (`scene`)
    x1, v1                displacement [m] and velocity [m/s] of the structure
    r, s                  shortening of the damper's spring, x1 - x2 + rest [m], and its rate [m/s]
    z, q                  depth of a contact [m], r - gap or -r - gap, and sqrt(z) (`law`)
    c, d                  cos and sin of the forcing's phase
    j, x                  number of a cell (or fixed step) in the period, place in it from 0 to 1
    w                     the table of a grid (`flight`) or of an arc (`impact`)
    k                     scratch rows of a contact (`scene.law`); elsewhere a power or a count
    h                     length of a cell or a step [s]; of a step in a contact, in theta
    theta                 fictitious time of a contact, dt = q dtheta (`taylor`)
    phi, u, S, b          phase, shape, speed and amplitude of a short impact (`impact`)
    kappa                 K / mu of a wall, mu the reduced mass
    bend, jerk            bounds of a second and of a third derivative by the place in a cell
    tangent               (16,) four variations (x1, v1, r, s), one after the other
    side, flight, watch   a wall with its bodies, the constants of a flight, buffers (`scene`)
    n                     cells or steps of a period; nodes of an arc; periods of an nT orbit
    y, z                  states (x1, v1, r, s) before and after a cell or a step

Arguments that belong together are one tuple (`scene`). This costs nothing if its arrays are bare
rows (`fours`), and `deciding` removes the branches of fields that are None.
"""
