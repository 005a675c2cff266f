"""What is under way: the folder of parts beside the archive to be.

In reading order:

    manifest     whose run it is
    partfile     one sealed part file
    folder       the folder of a run, and who holds it
    shard        the share of one of several machines
    interrupts   Ctrl-C and SIGTERM, heard between two pieces of work
    progress     how far, how fast, how long to go
    threads      how many threads the kernels use
"""
