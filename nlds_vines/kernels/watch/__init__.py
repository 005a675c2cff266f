"""What is seen of a piece of motion: touches, largest energies, a limit, a response.

In reading order:

    observe    what is noted along an orbit: impacts, energies, sections, a limit
    touch      the first touch in a cell, certified; near misses
    limit      a limit of the spring's shortening
    peaks      the largest energies in a piece of motion
    response   the response over the sampled periods: largest values, rms, powers
    walk       a motion on a wall that is linear, to what ends it
"""
