"""Error against run time of our methods and of SciPy on a system, and which tolerance to take.

In reading order:

    measure   the reference, and error and CPU time of each method at each setting
    picture   error against CPU time
    command   `python -m nlds_vines.accuracy`: table, picture and advice
"""
