"""Search for the damper that minimizes an objective, and test how robust the optima are.

In reading order:

    design_space  free parameters with bounds and scales; uncertain parameters and their draws
    request       `Tuning`: free parameters, objective, cases and search, validated
    result        columns of the log, datasets of the archive, and `Tuned`, which reads them
    run           the searches, from request to archive; trials of designs and their log
    picture       the objective over two parameters, or along the only one
    command       `nlds-vines tuning` and `nv.tune`
"""
