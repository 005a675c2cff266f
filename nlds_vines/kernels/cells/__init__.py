"""Cells of a map and of loads: orbits with their outputs, verdicts, branches, many at a time.

In reading order:

    verdict        the verdict on an orbit, with the evidence
    host_verdict   that on the orbit of a host
    cells          one cell: parameters, orbit, outputs, verdict; orbits that begin at any phase
    load_orbit     an orbit under a load, with jumps of the velocity; its energies at the edges
    cycles         an nT orbit as a point of a branch; orbits that come near known ones
    host_cycles    that of a host
    lanes          many cells, one after another
    load_numbers   response quantities under loads, for many orbits
"""
