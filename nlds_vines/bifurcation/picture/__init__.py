"""Diagrams of one varied parameter and maps of two, drawn from the archive alone.

In reading order:

    choices           the quantities that a picture can show
    regime_strip      the colored strip of regimes above a diagram
    diagram           over one parameter: strips; panels of dots, curves, spectra
    regime_map        two varied parameters: regimes, and how many coexist, by color
    basin_map         basins of attraction, and their shares along a parameter
    sample_panels     samples: histograms, exceedance, scatter against parameters
    curves            response curves, case by case
    drawing           what draws the archive of a scan: diagrams, maps, basins
"""
