"""What all commands have in common.

In reading order:

    parser           the argument parser
    option_values    --system, --set NAME=VALUE, START:STOP:NUM and their like
    setting_options  the options that override a request file, as its settings say
    run_options      the options that say how a run goes
    paths            checks of the paths that are written
    job              a request, where its results go and how it runs
    command_main     a command from its arguments to its exit status
    task_registry    the tasks by the kind of their archives
    commands         the names of all commands, and where they are
    markdown_tables  tables of pages and reports
"""
