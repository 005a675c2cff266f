"""Numbers in, numbers out: flight, touch, contact, orbit. Compiled; no I/O, no plotting.

In reading order:

    stored_code      what was compiled, on the disk
    linking          how an entry and all that it calls become one piece of machine code
    deciding         branches that the types of arguments decide: what is absent, which law
    compiling        how kernels are compiled
    by_law           which kernel is called where laws differ
    fours            rows of numbers: bare, and four numbers at a time
    elementary       sine, exponential, logarithm, roots and powers: the same bits everywhere
    codes            statuses, events and kinds of verdicts: each number once
    arguments        what travels together: Parts, Span, Side, Flight, Watch, buffers
    scene            structure, damper and walls as kernels see them; equation (5)
    laws             contact laws, each one file, and what they may say
    roots            the root finder; what two ends of a piece prove of the motion between
    observe          what is noted along an orbit: impacts, energies, sections, a limit
    drive            the force at an instant: harmonic, or a load
    flight           the exact flight: a period in cells, each a matrix and a Taylor polynomial
    once_rounded     cells without a bias, in twice the precision, where all else is linear
    touch            the first touch in a cell, certified; near misses; a limit
    peaks            the largest energies in a piece of motion
    response_sums    what a response is summed up from
    response         the response over the sampled periods: largest values, rms, powers
    load_cells       flight under a load: any force that is a polynomial over each cell
    exact            from one event to the next by these four
    response_steps   a response over Runge-Kutta steps
    fixed_step       the same by fixed Runge-Kutta steps (method rk4)
    contact_field    the equation of a contact, made smooth at touch and release
    runge_kutta      one step of it, of order eight or four
    limit            a limit inside a contact
    contact          a contact from touch to release, stepped
    quadrature       Gauss-Legendre points, and integrals of values there
    impact_series    a short impact as a power series in its small numbers
    impact           a short impact, solved at once
    hertz_arc        the free impact at the collocation nodes, which `impact` is given
    impact_variations   variations through it, on its collocation
    inside           half of it, from touch or from release; its largest energies
    state_inside     its state between touch and release
    inside_variations   variations there
    elastic_contact  a contact as the time loop asks for it, which is stepped in general
    sides            the two walls of a scene, of which one is touched
    response_inside  a response over a short impact
    orbit            the time loop: flights, contacts, sections
    recurrence       period and impacts of an orbit from its section
    growth           growth rates with their uncertainty; convergence of averages
    matrices         linear systems, determinants and eigenvalues of small matrices
    variations       the map from section to section with its derivative
    shooting         periodic orbits by Newton's method
    evidence_rows    the columns of a verdict's evidence
    course           an orbit under judgement: its sections, and how it is followed further
    settling         when it settled, and what it was before
    period_search    the stable periodic orbit that it ends in
    verdict          what an orbit is, with the evidence
    cells            one cell: parameters, orbit, outputs, verdict
    load_orbit       an orbit under a load, with jumps of speed
    part_period      an orbit that begins at any phase, to the next section
    driven           variations that parameters drive
    driven_flight    the same along a flight
    cycles           an nT orbit as a point of a branch, with its derivatives
    basins           orbits followed until they are certain to be drawn to a known attractor
    lanes            many cells, one after another

Words:

    cell (of a map)   one set of parameters; in `flight`, a cell is a piece of a forcing period
    chain, link       cells that are run one after another, and one of them; each starts from
                      the last state of the one before
    lane              what runs on its own: a chain
    period            one of the forcing, T = 2 pi / omega
    section           the states at the ends of the periods, or `stops` of them in each period
    record, evidence  the section of an orbit under judgement, and the numbers of its verdict
    variations        four small differences from an orbit; they obey the linearised equation

Letters:

    ps, damper, wall      the numbers of the structure, of the damper, of one wall (`scene`)
    x1, v1                displacement [m] and velocity [m/s] of the structure
    r, s                  shortening of the damper's spring, x1 - x2 + rest [m], and its rate [m/s]
    z, q                  depth of a contact [m], r - gap or -r - gap, and sqrt(z) (`laws.law`)
    c, d                  cos and sin of the forcing's phase
    j, x                  number of a cell (or fixed step) in the period, place in it from 0 to 1
    w                     the table of a grid (`flight`) or of an arc (`impact`)
    k                     scratch rows of a contact (`runge_kutta`); elsewhere a power or a count
    h                     length of a cell or a step [s]; of a step in a contact, in theta
    theta                 fictitious time of a contact, dt = q dtheta (`contact_field`)
    phi, u, S, b          phase, shape, speed and amplitude of a short impact (`impact`)
    kappa                 K / mu of a wall, mu the reduced mass
    bend, jerk            bounds of a second and of a third derivative by the place in a cell
    tangent               (16,) four variations (x1, v1, r, s), one after the other
    side, flight, watch   a wall with its bodies, a flight's parts, what notes (`arguments`)
    n                     cells or steps of a period; nodes of an arc; periods of an nT orbit
    y, z                  states (x1, v1, r, s) before and after a cell or a step

What travels together is one tuple (`arguments`). It costs nothing, if its arrays are bare rows
(`fours`), and `deciding` knows of each of its fields whether it is None.
"""
