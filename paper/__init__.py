"""The paper, figure by figure, and its claims checked against the archives.

In reading order:

    request        a figure: a page of curves, a scan or a portrait
    request_file   a request file (TOML) read into a request
    page_picture   a page of curves drawn from the archives of its scans
    claims/        what the paper says, each with the rule by which it is judged
    motion         orbits of figures, for the claims about them
    report         the page of claims and retention
    claims_page    Figure 8 to click, with the claims
    command        `python -m paper`
"""
