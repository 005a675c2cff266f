"""The system: a structure under a harmonic force and a damper joined to it, or an oscillator.

In reading order:

    parameter        one parameter: symbol, unit, range
    contact_laws     the contact laws, with the parameters that are theirs
    parameters       every parameter by name
    quantity         a recorded number: unit, words, where it is, how it is drawn
    quantities       every recorded number by name
    axis             a parameter and the values it takes
    scenes/          the kinds of systems, a file each
    ratios           damping ratios, mass ratio and Hz in place of parameters
    system           a kind with its parameters, checked
    catalog        the named systems, and the files that come with the program
    labels           what an orbit is, in the paper's words; of many, the frequent ones
    words            systems and parameters in a few words
    linear_response  the motion without contact, in closed form
    slow_manifold    the 1:1 response of a free mass between two walls, in closed form
    setting          the settings of requests, and documents read and merged
    load_quantities  every number that is told of a structure under a load
    loads/           forces and accelerations of the ground over time, a file for each family
"""
