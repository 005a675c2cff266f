"""Branches of periodic orbits along a parameter, stable or not: where and why regimes change.

In reading order:

    request              `Continuation`: what to follow, checked
    section_map          the n-fold stroboscopic map with its derivatives; linear systems
    arclength            predictor, Newton corrector, step control; the phase of rigid impacts
    special_points       test functions, their sign changes, branches that leave there
    branch_arm           one branch in one direction, and why it ends
    whole_branch         a whole branch, both directions joined, and its arrays
    exploration          all branches that start orbits lead to
    start_orbits         from rest, from random starts, from a scan's archive
    branch_table         the datasets of the archive
    special_curves       curves of special points in the plane of two parameters
    special_curve_table  the datasets of curves
    result               `Continued`: branches, special points, curves
    regime_borders       why a scan's regimes change
    run                  from request to archive
    marks                the mark of each kind of special point
    plane_picture        curves in their plane
    picture              the diagram of branches
    command              `python -m nlds_vines.continuation` and `nv.continue_branch`
"""
