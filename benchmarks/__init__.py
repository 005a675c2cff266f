"""What only measures the program or competes with it; in a clone: `python -m benchmarks.NAME`.

    accuracy   error against run time with solvers of others: docs/accuracy.md, docs/stiffness.md
    extremes   the catalogue of extremes, each promise measured afresh: docs/extremes.md
    speed      run times, as ratios to those of another checkout
    safety     what it costs that no result is lost
    boundary_values   special points of a branch, found a second time by SciPy's `solve_bvp`
    contact_laws   the same damper under each contact law: docs/contact-laws.md
    house      counts of the package: floors, circles, long functions, lines by folder
    rivals/    solvers of others that `accuracy` measures where they are installed

`speed`, `safety`, `extremes`, `boundary_values` and `house` need nothing beyond the program.  The
rivals are installed by `pip install '.[peers]'`; numbalsoda is built from its source, and needs
cmake and a Fortran compiler (gfortran) first.  GNU Octave is a program of its own: `octave-cli`
must be on the path.
"""
