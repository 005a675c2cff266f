"""Commands that only measure the program or compare it with others: `python -m benchmarks.NAME`.

    accuracy         error against run time with the solvers of others: docs/accuracy.md
    extremes         ten extremes and their bounds: docs/accuracy.md
    speed            CPU times, as ratios to those of an earlier state, and beside their kernels'
    cases            the pieces of work that `speed` times, by public names alone
    cold             the wait before the first orbit, and before what follows it
    costs            the cost of walls, limits and records
    load_costs       a cell under a load beside one under the harmonic force
    load_rivals      one blow beside the solvers of others
    hosts            frames of 1 to 20 storeys beside the solvers of others: docs/hosts.md
    contact_laws     the same damper under each contact law: docs/contact-laws.md
    polish           gradients in a tuning under a load: docs/tuning.md
    explore          the wait from a click to the drawn orbit, in a browser
    boundary_values  special points of a branch, computed again by SciPy's `solve_bvp`
    mutants          changes of a source that the tests must notice
    house            tokens, folded code, double names, and what one diagram executes

They work in a clone. The solvers of others are installed by `pip install '.[peers]'`; numbalsoda is
built from its source, and needs cmake and gfortran.
"""
