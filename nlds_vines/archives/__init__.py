"""What is finished: one HDF5 file, written whole and read by name.

In reading order:

    toml             TOML, as requests are written and archives keep them
    dataset          the description of datasets and dimensions; chunks and slabs
    record_columns   records that describe their own columns of a table
    durable          files that survive a power cut; locks
    provenance       where an archive comes from: request, versions, sources, machine
    representation   what an object says of itself, in Python and in a notebook
    frames           an archive for xarray, pandas, and as CSV
    view             an open archive: datasets by name, attributes, dimensions
    archive          the archive itself, written and read: alone imports h5py
    archive_path     its path, which can be read; one without a name lives as long as that
"""
