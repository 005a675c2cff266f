"""The paper, figure by figure, and its claims checked against the archives.

In reading order:

    request        the request of each figure: response curves, a scan or a portrait
    claims/        what the paper says, each with the rule by which it is judged
    motion         orbits of figures, for the claims about them
    report         the page of claims and retention
    claims_page    Figure 8 to click, with the claims
    command        `python -m paper`
"""
