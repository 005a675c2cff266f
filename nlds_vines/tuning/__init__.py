"""Search for the damper that minimizes an objective, and test how robust the optima are.

Modules in reading order: design_space, request, batch_of_designs, result, run, picture, command.
"""
