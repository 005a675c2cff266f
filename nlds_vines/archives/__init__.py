"""What is finished: one HDF5 file, written whole and read by name.

Modules in reading order: files, representation, dataset, provenance, contents, hdf5,
archive.
"""
