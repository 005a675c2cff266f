"""Orbits in Python, one or many.

Modules in reading order: solver_settings, records, responses, kernel_inputs, starts, compilation,
signals, spectrum, batch, host_orbits, host_batch, simulation, classification, load_flight,
host_loads.
"""
