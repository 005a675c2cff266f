"""Branches of periodic orbits along a parameter, stable or not: where and why regimes change.

In reading order:

    request         `Continuation`: parameter, interval, start, limits of the search
    section_map     the n-fold stroboscopic map with its derivatives; linear systems
    host_section_map  that of a host
    arclength       predictor, Newton corrector, step control; the phase of rigid impacts
    special_points  test functions, their sign changes, branches that leave there
    branch_arm      one branch in one direction, and the reason of its end
    exploration     all branches that start orbits lead to
    special_curves  curves of special points in the plane of two parameters
    result          `Continued`: branches, special points, curves, their datasets
    regime_borders  why a scan's regimes change
    run             start orbits; from request to archive
    picture         the diagram of branches, and curves in their plane
    command         `python -m nlds_vines.continuation` and `nv.continue_branch`
"""
