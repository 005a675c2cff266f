"""Loads in time: forces on m1, or accelerations of the ground, as Taylor coefficients over cells.

In reading order:

    series   Taylor coefficients of sines, exponentials and polynomials over cells
    load     `Load`: what every load says of itself, and its unit
    pulses   half-sine, triangular, rectangular, Friedlander, once or repeated
    waves    a harmonic, a sweep, band-limited noise
    samples  two columns of a file, CSV or HDF5
    record   samples with lines or a spline between them
    loading  `Loading`, the table `[load]`: a sum of these, and its cells
"""
