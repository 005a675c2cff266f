"""The compilation and storage of kernels, and shared arithmetic.

In reading order:

    stored_code   compiled kernels on the disk
    deciding      branches that the types of arguments decide: what is absent, which law
    compiling     how kernels are compiled and linked, and what that relies on in Numba
    fours         rows of numbers: bare, and four numbers at a time
    elementary    sine, exponential, logarithm, roots and powers: the same bits everywhere
    tones         sums of many tones as polynomials over cells of time
    roots         the root finder; what two ends of a piece prove of the motion between
    matrices      linear systems, determinants and eigenvalues of small matrices
"""
