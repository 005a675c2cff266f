"""Search for the damper with the least energy of the structure, and test how robust it is.

In reading order:

    free_parameter  a parameter that is free, its bounds and scale
    draws           what is uncertain, and the draws of it
    request         `Tuning`: what to search, checked
    objective       designs through the kernels: the number to be minimized
    searches        differential evolution, CMA-ES, Nelder-Mead
    evaluations     every evaluation of a design, kept on the disk
    optima          distinct optima, and the changes that test their robustness
    tuning_table    the datasets of the archive
    run             from request to archive
    result          `Tuned`: an archive read
    picture         the surface over two parameters
    command         `python -m nlds_vines.tuning` and `nv.tune`
"""
