"""Response curves: the largest energies against frequency, dampers beside each other.

In reading order:

    request        `CurvePage`: panels, curves and the scan of each
    request_file   a request file (TOML) read into a `CurvePage`
    curves_table   the datasets of the archive
    run            from request to archive, curve by curve
    result         `ResponseCurves`: an archive read
    curve_picture  how curves look, and the entries of a legend
    picture        a page of curves drawn
    command        `python -m nlds_vines.bifurcation.response_curves` and `nv.response_curves`
"""
