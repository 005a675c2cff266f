"""Branches of periodic orbits along a parameter, stable or not: where and why regimes change.

Modules in reading order: request, arclength, special_points, branch_arm, exploration,
special_curves, branch_panels, result, monitors, tori, regime_borders, run, picture, command.
"""
