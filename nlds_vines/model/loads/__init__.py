"""Loads in time: forces on m1 or accelerations of the ground, as Taylor coefficients over cells.

Modules in reading order: courses, record_text, formats, record, suite, loading.
"""
