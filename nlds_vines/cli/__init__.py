"""What all commands have in common.

parser          the argument parser
option_values   --system, --set NAME=VALUE, START:STOP:NUM and their like
paths           checks of the paths that are written
run_options     the options that say how a run goes
running         a command from its arguments to its exit status
"""
