"""Branches of periodic orbits along a parameter, stable or not: where and why regimes change.

In reading order:

    request              `Continuation`: what to follow, checked
    request_file         a continuation file (TOML) read into a `Continuation`
    section_map          the n-fold section map with its derivatives; linear systems
    arclength            a step along a branch, and Newton's method across it
    special_points       test functions, and where they change their sign
    branch_arm           one branch in one direction, and why it ends
    shooting_phase       when in its period an orbit of rigid bodies is shot from
    switching            onto the branches that leave it
    whole_branch         a whole branch, both directions joined, and its arrays
    exploration          all branches that start orbits lead to
    start_orbits         from rest, from random starts, from a scan's archive
    branch_table         the datasets of the archive
    defining_systems     what vanishes on a curve of special points
    curve_tracer         along such a curve
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
