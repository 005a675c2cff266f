"""Loads in time: forces on m1 or accelerations of the ground, as Taylor coefficients over cells.

In reading order:

    courses       the kinds of loads, from a pulse to noise
    record        records of earthquakes: the formats of their files, and a record as a load
    loading       the sum of loads, cell by cell
"""
