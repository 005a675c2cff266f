"""Error against run time with every rival that is installed, on any system or on five cases.

cases     five cases that stand for all, and 25 digits of what is true of them
curves    error against cost of one method: order, cost of an error
page      the tables, sentences and the page of an archive: docs/accuracy.md
command   `python -m benchmarks.accuracy`
"""
