"""What only measures the program or competes with it; in a clone: `python -m benchmarks.NAME`.

house      counts of the package: floors, circles, long functions, lines by folder
"""
