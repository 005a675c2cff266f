"""What is under way: the folder of blocks beside the archive to be, and who computes them.

Modules in reading order: store, interrupts, executors, run_options, progress.
"""
