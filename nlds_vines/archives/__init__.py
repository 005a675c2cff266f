"""What is finished: one HDF5 file, written whole and read by name.

In reading order:

    files            files that appear whole or not at all; TOML
    representation   the repr of an object, in Python and in a notebook
    dataset          the description of datasets and dimensions
    provenance       where an archive comes from: request, versions, sources, machine
    archive          the archive, written and read; its path; for xarray, pandas and as CSV
"""
