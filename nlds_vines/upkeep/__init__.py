"""Look after archives and runs.

Modules in reading order: branches_picture, plot, rerun, export.
"""
