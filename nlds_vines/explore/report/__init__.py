"""A map or a diagram as one page (.html) that needs no server and no network.

In reading order:

    branch_lines  branches and special points of a continuation, over the map
    report_page   the page put together, the numbers of all cells in few bytes
    command       `python -m nlds_vines.explore.report`, `nlds-vines report`
"""
