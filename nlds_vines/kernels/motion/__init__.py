"""The linear motion between events, its variations, and the equation of a contact.

In reading order:

    bounds          how fast the linear motion may change
    flight          the exact flight: a period in cells, each a matrix and a Taylor polynomial
    load_cells      flight under a load: any force that is a polynomial over each cell
    driven          variations that parameters drive
    driven_flight   the same along a flight
    response_sums   what a response is summed up from
    runge_kutta     a step of a contact by rk4
    taylor          a step of a contact, made smooth at touch and release, as Taylor polynomials
"""
