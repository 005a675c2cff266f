"""Diagrams of one varied parameter and maps of two, drawn from the archive alone.

In reading order:

    choices        what a map may show
    diagram        one varied parameter: sections, energies, exponents over it
    regime_strip   the coloured strip of regimes above a diagram
    map_cells      the panel of a map: its cells filled, and marked with dots
    regime_map     two varied parameters: regimes, and how many coexist, by colour
    number_map     two varied parameters: a recorded number by shade
    share_map      two varied parameters: the share of the starts that end in a regime
    drawing        from the path of an archive to the path of its picture
"""
