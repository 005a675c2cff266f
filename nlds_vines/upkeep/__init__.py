"""Commands over all tasks: look after archives and runs, and serve and send pages of them.

Modules in reading order: tasks, branches_picture, plot, rerun, export, explore, report.
"""
