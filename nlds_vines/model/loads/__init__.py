"""Loads in time: forces on m1 or accelerations of the ground, as Taylor coefficients over cells.

In reading order:

    courses       the kinds of loads, from a blow to noise
    record_files  the formats of records of earthquakes
    record        a record as a load, and what was read of it in a line
    loading       the sum of loads, cell by cell
"""
