"""A cell as kernels see it: its bodies, its walls and their law, its force.

In reading order:

    codes    statuses, events and kinds of verdicts, and the columns of evidence: each number once
    by_law   which kernel is called where laws differ
    law      what a law may say, what holds where it does not, and the series of a contact
    scene    structure, damper and walls; equation (5); what travels together: Parts, Side, Watch
    drive    the force at an instant: harmonic, or a load
"""
