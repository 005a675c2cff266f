"""What all commands have in common.

Modules in reading order: entry, terminal, options, running, command.
"""
