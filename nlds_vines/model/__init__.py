"""Systems: a structure under a harmonic force with a damper joined to it, or an oscillator.

In reading order:

    parameters       parameters: symbol, unit, range; the contact laws; initial conditions
    scenes           the kinds of systems
    quantities       recorded numbers: unit, meaning, where they are stored, how they are drawn
    axis             a parameter with its values, or with its bounds; tables of parameter sets
    ratios           damping ratios, mass ratio and Hz in place of parameters
    system           a kind with its parameters, validated
    catalog          the named systems, and the files that come with the program
    labels           regimes by name; the most frequent and the coexisting ones of many orbits
    linear_response  the motion without contact in closed form
    host             linear structures of any number of degrees of freedom: frames, beams, chains
    host_system      a host with dampers and walls
    slow_manifold    the 1:1 response of a free mass between two walls in closed form
    setting          the settings of requests; documents read, merged and validated
    loads/           forces and ground accelerations over time
"""
