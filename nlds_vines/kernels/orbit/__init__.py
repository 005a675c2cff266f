"""The time loop, the map from section to section, and its derivative.

In reading order:

    orbit        the time loop: flights, contacts, sections
    repetition   periods that repeat to the bit are copied
    recurrence   period and impacts of an orbit from its section
    variations   the map from section to section with its derivative; periodic orbits
"""
