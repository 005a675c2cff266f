"""Diagrams of one varied parameter and maps of two, drawn from the archive alone.

In reading order:

    ordinates         what is recorded in numbers, whatever it is; along one parameter
    choices           what a picture may show
    attractor_styles  orbits of one attractor look alike, whatever their start
    dot_panel         one quantity over one parameter, or spectra
    regime_strip      the colored strip of regimes above a diagram
    diagram           strips and panels over one parameter
    regime_map        two varied parameters: regimes, and how many coexist, by color
    basin_map         basins of attraction, and their shares along a parameter
    drawing           what draws the archive of a scan: diagrams, maps, basins
"""
