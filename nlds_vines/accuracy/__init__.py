"""Error against run time of every method on a system, and against the stiffness of its contact.

In reading order:

    cases              what is followed
    rivals/            naive RK4 and SciPy's solvers, used as their users would
    columns            records that describe their own columns of a table
    results            one measurement, as such records
    reference          the true states, with witnesses
    rigid              the limit of an infinitely hard contact
    contenders         every method with its settings from coarse to fine
    measure            the error and the cost of one setting
    survey             many measurements into one archive, resumable
    comparison         all methods on some cases
    comparison_table   an archive of it read
    comparison_page    its tables and its page
    curves             error against cost of one method: order, cheapest setting
    stiffness          all methods over the stiffness of the contact
    stiffness_table    an archive of it read, its tables and its page
    costs              what each part and each record costs
    request            what the command can measure
    picture            both drawn
    command            `python -m nlds_vines.accuracy`
"""
