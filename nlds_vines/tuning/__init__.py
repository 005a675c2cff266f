"""Search for the damper that minimizes an objective, and test how robust the optima are.

Modules in reading order: design_space, request, result, run, picture, command.
"""
