"""Cells of a map: verdicts, branches, basins, many cells one after another.

In reading order:

    verdict        what an orbit is, with the evidence
    cells          one cell: parameters, orbit, outputs, verdict; orbits that begin at any phase
    load_orbit     an orbit under a load, with jumps of speed, and its energies at the edges
    cycles         an nT orbit as a point of a branch; orbits that come near known ones
    lanes          many cells, one after another
    load_numbers   times, energies and the rms of x1 under a load, for many orbits
"""
