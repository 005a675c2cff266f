"""The linear motion between events, its variations, and the equation of a contact.

In reading order:

    flight          bounds of the motion; the exact flight: cells, each a matrix and a polynomial
    load_cells      flight under a load: any force that is a polynomial over each cell
    driven          variations that parameters drive, at walls and along flights
    response_sums   what a response is summed up from
    taylor          a step of a contact, smooth at touch and release; the same by Runge and Kutta
"""
