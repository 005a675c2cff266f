"""Search for the damper that minimizes an objective, and test how robust the optima are.

In reading order:

    design_space  free parameters with bounds and scales; uncertain parameters and their draws
    request       `Tuning`: free parameters, objective, cases and search, validated
    objective     trials of designs, the log of a search, perturbations of an optimum
    result        the datasets of the archive, and `Tuned`, which reads them
    run           the searches, from request to archive
    picture       the objective over two parameters, or along the only one
    command       `nlds-vines tuning` and `nv.tune`
"""
