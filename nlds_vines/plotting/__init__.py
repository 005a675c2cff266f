"""The kit that all pictures are drawn with.

In reading order:

    notation        plain text as it is printed: symbols, powers of ten, units
    style           sizes, fonts, colors; meaning, symbol and unit along an axis
    page            one column or two; panels, titles, legends; our settings beneath the user's
    palette         the colors of regimes and of dampers
    bands           runs of equal labels along an axis; borders between cells; places for names
    chosen_panels   what draws archives: all panels, some, or one in axes of the user
    drawable        results that can be drawn
    save            a figure written to a file, with its origin in the metadata
"""
