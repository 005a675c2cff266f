"""Scan one parameter or two: a bifurcation diagram or a map, in an archive and a picture.

In reading order:

    request           `Scan`: what to compute, and how a scan file (TOML) is read into one
    datasets          the datasets of a scan's archive
    attractors        groups ends of orbits, matches attractors along parameters
    attractor_ends    where orbits end, with an early stop near known cycles
    attractor_table   the attractors as datasets of the archive
    blocks            the rectangles of cells that are computed as one; whether there is room
    compute           one block through the kernels
    orbit_counts      counts of orbits: done, failed, of each regime
    observation_time  for how long chaos was watched, in words
    run               block after block, from request to archive
    cluster           blocks on the workers of a Dask cluster
    cell_start        where the orbits of a scan begin, and those of a cell
    cell_orbit        from a cell of an archive to its orbit, the same to the last bit
    result            the archive as a path that can be read and drawn, and its scan
    picture/          diagrams and maps, drawn from the archive alone
    response_curves/  several dampers in one archive, with a dimension `case`
    command           `python -m nlds_vines.bifurcation` and `nv.scan`
"""
