"""Diagrams of one varied parameter and maps of two, drawn from the archive alone.

In reading order:

    ordinates         what is recorded in numbers, whatever it is
    choices           what a picture may show
    scan_slice        the results along one parameter
    attractor_styles  orbits of one attractor look alike, whatever their start
    dot_panel         one quantity over one parameter
    waterfall         spectra over a parameter
    regime_strip      the coloured strip of regimes above a diagram
    strip_layout      how many strips, and what their legend says
    diagram           strips and panels over one parameter
    map_panel         the panel of a map: its cells filled, hatched, and marked
    region_names      names written into the regions of a map
    regime_map        two varied parameters: regimes, and how many coexist, by colour
    quantity_map      two varied parameters: a recorded number by shade
    code_map          two varied parameters: a recorded code by colour, as the kind of modulation
    manifold_bounds   the frequencies of 1:1 motion in closed form, over a map
    regime_shares     two varied parameters: the share of the starts that end in a regime
    basin_map         basins of attraction, and their shares along a parameter
    drawing           from the path of an archive to the path of its picture
"""
