"""What is under way: the folder of parts beside the archive to be.

In reading order:

    manifest         which request the parts belong to, and who began it
    partfile         one part file
    folder           the folder of a run, and its locks
    numbered_parts   the folder of a run whose parts have numbers
    interrupts       Ctrl-C and SIGTERM, which end a run between two pieces of work
    progress         how much is done, how fast, how long to go
    journal          a run from its folder to its archive
    executors        threads that the kernels use, shards; processors, free memory and disk
"""
