"""What all commands have in common.

In reading order:

    terminal         what a command prints, its errors as one line each, its exit status
    options          the parser; options from settings, for tables of parameters; their texts
    run_options      the options that say how a run goes
    paths            checks of the paths that are written
    task_registry    the tasks by the kind of their archives
    command          a command from its arguments to its exit status; the commands of tasks
    commands         the names of all commands, and where they are
    markdown_tables  tables of pages and reports
    command_main     for modules that are not yet written anew, as these four
    job              ..
    parser           ..
    option_values    ..
    setting_options  ..
"""
