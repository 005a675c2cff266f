"""The kit that all pictures are drawn with.

In reading order:

    style           sizes, fonts, colors; text as it is printed, and labels of axes
    page            one column or two; panels, titles, legends; our settings beneath the user's
    palette         the colors of regimes and of dampers
    bands           runs of equal labels along an axis; borders between cells; places for names
    chosen_panels   what draws archives: all panels, some, or one in axes; figures saved
    drawable        results that can be drawn
"""
