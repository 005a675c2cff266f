"""What all commands have in common.

In reading order:

    terminal  what a command prints, its errors as one line each, its exit status
    options   the parser; options from settings, for tables of parameters; how texts are read
    running   the options that say how a run goes; checks of the files that it writes
    command   a command from its arguments to its exit status; tasks, their jobs and commands
"""
