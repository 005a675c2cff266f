"""A short impact, solved at once.

In reading order:

    arc      the Hertz arc at the collocation nodes, and the series of an impact in small numbers
    impact   an impact at touch, and its solution by collocation
    inside   variations and responses through it; states and energies between touch and release
"""
