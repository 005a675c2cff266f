"""The compilation and storage of kernels, and shared arithmetic.

In reading order:

    stored_code   compiled kernels on the disk
    deciding      branches that the types of arguments decide: absent parts, laws
    compiling     how kernels are compiled and linked, and what that relies on in Numba
    fours         bare rows, and vectors of four numbers
    elementary    sine, exponential, logarithm, roots and powers: the same bits everywhere
    tones         sums of many tones as polynomials over cells of time
    roots         root finding in a bracket; bounds of a motion from the two ends of a piece
    matrices      linear systems, determinants and eigenvalues of small matrices
"""
