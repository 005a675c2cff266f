"""What all commands have in common.

Modules in reading order: terminal, options, running, command.
"""
