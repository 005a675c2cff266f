"""Error, cost and touches of every method as the contact of a system is made softer and harder.

rigid     the limit of an infinitely hard contact
table     the table of an archive, and its page: docs/stiffness.md
survey    all methods over the stiffness of the contact
command   `python -m benchmarks.stiffness`
"""
