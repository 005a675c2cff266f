"""The record `attractor` of a scan: to which attractor each orbit comes, by its number.

In reading order:

    attractor_matching    closed stable orbits, and the region from which orbits come to one
    attractor_numbering   the attractors of systems along a parameter, each with its number
    attractor_additions   those that a sample has missed
    attractor_assignment  attractors are learnt, then cells are followed to them
"""
