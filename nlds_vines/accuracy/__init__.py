"""Error against run time of our methods and of SciPy on a system, and which tolerance to take.

Modules in reading order: measure, picture, command.
"""
