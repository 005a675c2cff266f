"""The time loop, the map from section to section, and its derivative.

In reading order:

    orbit        the time loop: flights, contacts, sections
    repetition   periods that repeat to the bit, and n and k of an orbit that repeats to a tolerance
    variations   the map from section to section with its derivative; periodic orbits
"""
