"""What is finished: one HDF5 file.

In reading order:

    dataset      a dataset and a dimension, described
    durable      files that survive a power cut; seals, locks
    provenance   where an archive comes from
    archive      written whole, read by name, verified: the only module that imports h5py
"""
