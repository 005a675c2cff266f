"""Systems: a structure under a harmonic force with dampers joined to it, or an oscillator.

Modules in reading order: parameters, scenes, quantities, axis, ratios, signals, presets,
linear_response, dampers, rests, system, host_matrices, host, catalog, labels,
spring_manifold, slow_manifold, setting, look, loads.
"""
