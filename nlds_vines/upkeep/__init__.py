"""Look after archives and runs.

In reading order:

    branches_picture  branches of a continuation over the energies of a sweep
    plot              a finished archive opened, as its results, or drawn
    rerun             what an archive holds repeated, and compared
    export            an archive as comma-separated values
"""
