"""The linear motion between events, its variations, and the equation of a contact.

In reading order:

    flight          bounds of the motion; the exact flight: cells, each a matrix and a polynomial
    load_cells      flight under a load: any force that is a polynomial over each cell
    driven          variations that parameters drive, at walls and along flights
    response_sums   the sums and maxima of a response
    taylor          a step of a contact, smooth at touch and release, by Taylor or Runge-Kutta
"""
