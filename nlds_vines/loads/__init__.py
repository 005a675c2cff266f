"""Loads in time: blows, blasts, earthquakes, sweeps and noise, with each damper.

In reading order:

    request       `HistoryRequest`: the dampers, the load, what varies, how long
    fall          what becomes of one structure: histories, last times, where the energy goes
    cases         its orbits: systems and loads in cells, flown by the kernels, and what they tell
    run           from request to archive: damper by damper, or a scan block by block
    closed_form   what a structure without walls does, in closed form
    result        an archive read: `ResponseHistories`, or `LoadScan`
    picture       energies and motions over time, shares, sweeps
    load_options  options of the command line that mean a load
    command       `python -m nlds_vines.loads` and `nv.response_history`
"""
