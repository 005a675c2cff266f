"""Loads in time: blows, blasts, earthquakes, sweeps and noise, with each damper.

In reading order:

    request            `HistoryRequest`: the dampers, the load, what varies, how long
    datasets           names and datasets of quantities and histories, of hosts also of impacts
    run                from request to archive; orbits flown by the kernels, and their numbers
    result             an archive read: `ResponseHistories`, or `LoadScan`; closed forms beside them
    response_spectrum  `nv.response_spectrum`: oscillators under a record
    picture            energies and motions over time, shares, sweeps; scans as curves and maps
    command            `python -m nlds_vines.loads` and `nv.response_history`
"""
