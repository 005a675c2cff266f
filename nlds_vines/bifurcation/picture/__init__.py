"""Diagrams of one varied parameter and maps of two, drawn from the archive alone.

In reading order:

    choices           the quantities that a picture can show
    diagram           over one parameter: strips of regimes; panels of dots, curves, spectra
    maps              two varied parameters: regimes, how many coexist, numbers, basins, by color
    drawing           what draws the archive of a scan: diagrams, maps, basins, samples
    curves            response curves, case by case
"""
