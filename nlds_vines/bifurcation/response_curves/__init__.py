"""Response curves: response quantities against frequency, dampers beside each other.

In reading order:

    request   `CurveRequest`: cases, the scan of each and the look of its curve; its file
    run       from request to archive, whose datasets are those of scans with a dimension `case`
    result    `ResponseCurves`: an archive read
    picture   curves drawn from the archive
    command   the command `response-curves` and `nv.response_curves`
"""
