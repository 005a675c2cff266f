"""Diagrams of one varied parameter and maps of two, drawn from the archive alone.

In reading order:

    ordinates         what is recorded in numbers, whatever it is; along one parameter
    choices           what a picture may show
    attractor_styles  orbits of one attractor look alike, whatever their start
    dot_panel         one quantity over one parameter, or spectra
    regime_strip      the colored strip of regimes above a diagram
    diagram           strips and panels over one parameter
    map_panel         the panel of a map: cells filled, hatched, marked; regions named
    regime_map        two varied parameters: regimes, and how many coexist, by color
    quantity_map      two varied parameters: a recorded number, or a share of starts, by shade
    manifold_bounds   the frequencies of 1:1 motion in closed form, over a map
    basin_map         basins of attraction, and their shares along a parameter
    drawing           what draws the archive of a scan: diagrams, maps, basins
"""
