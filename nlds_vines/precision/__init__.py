"""How exact and how fast: every method on one orbit, the stiff limit, and what came of it.

`cases` says what is followed, `reference` what is true, `contenders` who competes; `measure` holds
one against the other, `curves` reads orders, costs and advice from that.
"""
