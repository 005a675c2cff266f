"""A cell as kernels see it: its bodies, its walls and their law, its force.

In reading order:

    codes           statuses, events and kinds of verdicts: each number once
    evidence_rows   the columns of a verdict's evidence
    by_law          which kernel is called where laws differ
    contact_series  where the series of a contact stand, and how those of products follow
    law             what a law may say, and what holds where it does not
    scene           structure, damper and walls as kernels see them; equation (5)
    arguments       what travels together: Parts, Span, Side, Flight, Watch, buffers
    drive           the force at an instant: harmonic, or a load
"""
