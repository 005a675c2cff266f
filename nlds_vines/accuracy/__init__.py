"""Error against run time of our methods and of SciPy on a system, and what tolerance to take.

In reading order:

    measured_cases  what is measured, and what came of it
    scipy_solver    SciPy's solver, as everybody would use it first
    reference       the true states, with witnesses
    measure         the error and the cost of each method at each setting
    tables          what was measured in words, and advice
    picture         the same drawn
    command         `python -m nlds_vines.accuracy`
"""
