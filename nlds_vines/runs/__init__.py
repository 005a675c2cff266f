"""What is under way: the folder of blocks beside the archive to be, and who computes them.

In reading order:

    store        finished blocks, saved and loaded; a run from its first block to its archive
    interrupts   Ctrl-C and SIGTERM, which end a run between two pieces of work
    executors    threads that the kernels use, other workers, shards; free memory and disk
    progress     how much is done, how fast, how long to go
"""
