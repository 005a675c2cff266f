"""Search for the damper that minimizes an objective, and test how robust the optima are.

In reading order: design_space, request, objective, result, run, picture, command.
"""
