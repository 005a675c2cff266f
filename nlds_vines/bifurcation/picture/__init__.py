"""Diagrams of one varied parameter and maps of two, drawn from the archive alone.

In reading order:

    choices        what a map may show
    diagram        one varied parameter: sections, energies, exponents over it
    regime_strip   the coloured strip of regimes above a diagram
    regime_map     two varied parameters: regimes by colour
    number_map     two varied parameters: a number by shade
    drawing        from the path of an archive to the path of its picture
"""
