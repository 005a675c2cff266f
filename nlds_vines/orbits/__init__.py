"""Orbits in Python, one or many.

In reading order:

    solver_settings   methods, their tolerances and steps, the effort of a verdict
    records           words of records, rows of impacts, modulation, statuses
    responses         the quantities of a response, with units
    kernel_inputs     a scene and a cell as the kernels take them
    starts            policies of starts, random starts
    compilation       messages about compiling, and a second process that compiles
    spectrum          signals of an orbit, their spectra, the spectral records of scans
    batch             many orbits in one call of the kernels, datasets of verdicts and spectra
    host_orbits       orbits of hosts
    host_batch        many orbits of hosts
    simulation        `nv.simulate` and `nv.spectrum`
    classification    `nv.classify`, the Lyapunov spectrum of one orbit
    load_flight       orbits under loads in time
    host_loads        orbits of hosts under loads in time
"""
