"""Orbits in Python, one or many.

Modules in reading order: solver_settings, records, responses, starts, compilation,
signals, spectrum, batch, host_orbits, host_batch, simulation, classification, load_flight,
host_loads.
"""
