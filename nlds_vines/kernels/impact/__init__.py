"""A short impact, solved at once.

In reading order:

    impact_series       a short impact as a power series in its small numbers
    arc_table           where the numbers of an arc stand, and its nodes
    approach            an impact at touch: five small numbers, their products, their variations
    impact              a short impact, solved at once
    hertz_arc           the free impact at the collocation nodes, which `impact` is given
    impact_variations   variations through it, on its collocation
    impact_response     a response over it, summed up at its nodes
    inside              what is asked of one between touch and release, which is stepped
"""
