"""The parts of a cell in kernels: bodies, walls and their law, force.

In reading order:

    codes    statuses, events and kinds of verdicts, and the columns of evidence
    by_law   the choice of a kernel by the wall's law
    law      the kernels of a law, the general ones of a stepped contact, and its series
    scene    structure, damper and walls; equation (5); tuples that kernels pass on
    drive    the force at an instant: harmonic, or a load
"""
