"""Scan one parameter or two: a bifurcation diagram or a map, in an archive and a picture.

Modules in reading order: request, response_curves, result, blocks, run, attractors,
picture, command, curves_command.
"""
