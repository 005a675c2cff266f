"""How long chaos lasts, and where starts end: in one cell, or over a plane of starts.

Modules in reading order: ensemble, picture, command, basins.
"""
