"""Loads in time: forces on m1 or accelerations of the ground, as Taylor coefficients over cells.

In reading order: courses, record, loading.
"""
