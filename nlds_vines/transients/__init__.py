"""How long chaos lasts, and where starts end: in one cell, or over a plane of starts.

In reading order:

    ensemble        the starts of one cell: which settled, when, where; the law of their lifetimes
    picture         the curve with its law, and the shares of the final regimes
    command         `python -m nlds_vines.transients` and `nv.transient_lifetimes`
    basins          basins of attraction measured: `nv.basin_measures`
"""
