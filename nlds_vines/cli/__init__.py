"""What all commands have in common.

In reading order:

    terminal         what a command prints, its errors as one line each, its exit status
    options          the parser; options from settings, for tables of parameters; their texts
    run_options      the options that say how a run goes
    paths            checks of the paths that are written
    command          a command from its arguments to its exit status; tasks and their jobs
    command_main     for modules that are not yet written anew, as these four
    job              ..
    parser           ..
    option_values    ..
    setting_options  ..
"""
