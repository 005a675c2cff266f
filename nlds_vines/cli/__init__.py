"""The manners that all commands share.

In reading order:

    parser        the argument parser, options NAME=VALUE
    paths         checks of the paths that are written
    running       exit statuses, one line for an error
    run_options   the options that say how a run goes
    markdown      tables of pages and reports
"""
