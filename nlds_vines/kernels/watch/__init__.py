"""Records of a piece of motion: touches, largest energies, a limit, a response.

In reading order:

    observe    the records along an orbit: impacts, energies, sections, a limit
    touch      the first touch in a cell, certified; near misses; a limit of the spring's shortening
    response   largest energies and the response of a piece of motion; motions on a linear wall
"""
