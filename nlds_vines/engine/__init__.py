"""Orbits in Python, one or many.

`engine` chooses the kernels of a system, for all that tasks ask of them.

Modules in reading order: engine, simulation, classification, one_orbit, solver_settings, records,
responses, starts, compilation, spectrum, section_map, load_task, kind_engine, batch, load_flight,
host_engine, host_orbits, host_batch, host_section_map, host_loads.
"""
