"""Systems: a structure under a harmonic force with a damper joined to it, or an oscillator.

Modules in reading order: parameters, scenes, quantities, axis, ratios, system, catalog, labels,
linear_response, host_matrices, host, host_system, slow_manifold, setting, loads.
"""
