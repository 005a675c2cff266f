"""Loads in time: blows, blasts, earthquakes, sweeps and noise, with each damper.

Modules in reading order: request, datasets, run, result, response_spectrum, picture, command.
"""
