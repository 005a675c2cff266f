"""Look after archives and runs.

In reading order:

    branches_picture  branches of a continuation over the energies of a sweep
    plot              a finished archive drawn
    opening           what an archive holds, as the function returns it that has computed it
    rerun             what an archive holds repeated, and compared
    export            an archive as comma-separated values
"""
