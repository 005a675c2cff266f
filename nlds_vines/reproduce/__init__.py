"""The paper, figure by figure, and its claims checked against the archives.

In reading order:

    request        a figure: panels, curves and the scan of each
    request_file   a request file (TOML) read into a request
    picture        a figure drawn
    claims/        what the paper says, each with the rule by which it is judged
    motion         orbits of figures, for the claims about them
    report         the page of claims and retention
    command        `python -m nlds_vines.reproduce`
"""
