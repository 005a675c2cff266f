"""The kit that all pictures are drawn with.

Modules in reading order: style, page, palette, bands, chosen_panels, drawable.
"""
