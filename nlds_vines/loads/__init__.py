"""Loads in time: blows, blasts, earthquakes, sweeps and noise, with each damper.

Modules in reading order: floor_motion, response_spectrum, scaling, request, datasets, run, units,
result, picture, command.
"""
