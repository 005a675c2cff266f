"""Loads in time: blows, blasts, earthquakes, sweeps and noise, with each damper.

In reading order: request, run, result, response_spectrum, picture, command.
"""
