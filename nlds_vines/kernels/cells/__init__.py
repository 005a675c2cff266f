"""Cells of a map: verdicts, branches, basins, many cells one after another.

In reading order:

    course          an orbit under judgement: its sections, and how it is followed further
    settling        when it settled, and what it was before
    period_search   the stable periodic orbit that it ends in
    verdict         what an orbit is, with the evidence
    cells           one cell: parameters, orbit, outputs, verdict
    part_period     an orbit that begins at any phase, to the next section
    load_orbit      an orbit under a load, with jumps of speed
    cycles          an nT orbit as a point of a branch, with its derivatives
    basins          orbits followed until they are certain to be drawn to a known attractor
    lanes           many cells, one after another
    load_edges      an orbit under a load at the edges of cells, and bounds in between
    load_times      when E1 is largest, and when it last exceeds a level
    load_numbers    the numbers of an orbit under a load: last times, energies, the rms of x1
    load_lanes      many orbits under loads, one after another
"""
