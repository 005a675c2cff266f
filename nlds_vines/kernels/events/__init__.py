"""From one event to the next: a flight to a touch, a contact to its release.

In reading order:

    exact        a flight to the next touch or section: exact cells, certified touches
    fixed_step   a flight by fixed Runge-Kutta steps (method rk4)
    contact      a contact from touch to release, stepped, with its variations; near and far wall
"""
