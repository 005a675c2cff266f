"""The record `attractor` of a scan: to which attractor each orbit comes, by its number.

In reading order:

    known_attractors      closed stable orbits, and the region from which orbits come to one
    attractor_learning    the attractors of systems along a parameter, each with its number
    attractor_additions   those that a sample has missed
    attractor_record      attractors are learnt, then cells are followed to them
"""
