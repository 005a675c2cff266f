"""Systems: a structure under a harmonic force with a damper joined to it, or an oscillator.

In reading order: parameters, scenes, quantities, axis, ratios, system, catalog, labels,
linear_response, slow_manifold, setting, loads.
"""
