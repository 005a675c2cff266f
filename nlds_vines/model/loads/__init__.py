"""Loads in time: forces on m1, or accelerations of the ground, as Taylor coefficients over cells.

In reading order:

    courses  `Load` and `Course`: Taylor coefficients, pulses, a harmonic, a sweep, noise
    record   samples with lines or a spline between them, from two columns of a file
    loading  `Loading`, the table `[load]`: a sum of these, and its cells
"""
