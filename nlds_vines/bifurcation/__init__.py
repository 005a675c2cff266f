"""Scan one parameter or two: a bifurcation diagram or a map, in an archive and a picture.

In reading order:

    request           `Scan`: what to compute, how a scan file (TOML) is read, which datasets result
    response_curves   `CurveRequest`: several scans, one for each damper; results, command
    result            `ScanArchive`, the scan of an archive, where its orbits begin; orbits of cells
    blocks            the rectangles of cells that are computed as one; whether there is room
    run               one block through the kernels; block after block, from request to archive
    cluster           workers of a Dask cluster, which compute blocks
    attractors        where orbits end, with an early stop near cycles; groups and numbers of ends
    picture/          diagrams, maps and response curves, drawn from the archive alone
    command           `python -m nlds_vines.bifurcation` and `nv.scan`
"""
