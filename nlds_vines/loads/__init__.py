"""Loads in time: a structure that is struck, with each damper, and where its energy goes.

In reading order:

    request       `Decay`: the dampers, the blow, how long
    request_file  a request file (TOML), or what stands for one, read into a `Decay`
    fall          how the energy of one structure falls after a blow
    run           from request to archive, damper by damper
    result        `Decays`: an archive read
    picture       the energies over time, and the shares that dashpots and contacts take
    command       `python -m nlds_vines.loads` and `nv.decay`
"""
