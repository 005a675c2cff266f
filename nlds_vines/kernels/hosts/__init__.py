"""Orbits of hosts: any number of degrees of freedom, dampers and walls.

In reading order:

    modes            the modes of a host, without LAPACK
    body             the linear system, and its motion over a short time
    grid             the tables of its flight: propagators, and bounds that certify touches
    springs          springs that are not linear, and their series in a step
    cell_constants   matrices of Gauss nodes for them
    spring_cells     flight under them in long cells, by an integral equation
    walls            walls of all laws, and the state and the forces of those in contact
    host_flight      from a state to the next touch
    host_energies    the largest energies along flights and in short impacts
    host_watch       the response of rows, and records of contacts that are stepped
    host_variations  derivatives in flight, in contacts, and where the motion jumps
    host_impact      a short impact by scalars of the gap, which acts as a jump
    host_contact     from touch to release, several walls at once
    host_space       the norm of states, and the sections of a record
    host_repetition  periods that repeat to the bit are copied
    host_orbit       the time loop, and the flow from section to section
    host_load        loads in time: the same over cells of a load

The state is y = (X, V): the amplitudes of the host's modes, with a modal mass of 1 kg, and the
displacements of the dampers' masses [m]; then their rates. A link is a damper: its spring and
dashpot act along r = w X, and its walls limit r. The flight is dense: an exact propagator of the
whole linear system over a cell, so that any damping, double eigenvalues and motion without
stiffness are covered alike, by strict arithmetic without eigenvectors.
"""
