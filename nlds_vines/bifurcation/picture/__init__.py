"""Diagrams of one varied parameter and maps of two, drawn from the archive alone.

Modules in reading order: choices, diagram, maps, drawing, curves.
"""
