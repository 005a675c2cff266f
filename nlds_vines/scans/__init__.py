"""Scans: requests whose results are arrays over cells, computed block by block into one archive.

Modules in reading order: block, run_report, run, scan_job, cluster.
"""
