"""The kit that all pictures are made of.

In reading order:

    style     sizes, fonts, colours, labels of axes
    palette   colours of regimes
    bands     runs of equal labels along an axis, edges between values
    save      a figure into a file, with its origin
"""
