"""One orbit or many, in Python.

In reading order:

    solver_settings   methods, their fineness, the effort of a verdict
    records           what may be recorded
    responses         what a response holds, with units
    modulation        amplitudes, and 1:1 capture by impacts a period
    status_words      how a computation ended
    kernel_inputs     scene and cell as kernels take them
    starts            where orbits begin
    compilation       which kernels are compiled, and who is told
    batch             many orbits in one call of the kernels
    phase_entry       orbits that begin at any phase, to the next section
    compiler_process  the program of the process that compiles beside this one
    evidence          from the kernels' numbers to datasets and labels
    impact_rows       what is told of an impact, and of a limit
    simulation        `nv.simulate`
    load_flight       an orbit under a load in time
    load_batch        many orbits under loads, each with its numbers
    classification    `nv.classify`
    signals           forces, energies, relative displacement
    tapers            window functions of spectra
    spectral_records  what a scan records of spectra
    spectrum          `nv.spectrum`
    spectral_values   what these records are of an orbit
"""
