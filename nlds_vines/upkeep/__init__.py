"""Look after archives and runs.

In reading order:

    basin_report    basins of attraction in an archive measured
    edge_states     orbits between two basins, from a continuation
    marks_picture   orbits of other archives in basins, in a portrait, beside a sweep
    status          how a scan under way stands
    plot            a finished archive drawn
    opening         what an archive holds, as the function returns it that has computed it
    consolidate     the parts of shards joined into an archive
    rerun           what an archive holds repeated, and compared
    diff            what differs between two archives
    export          an archive as comma-separated values
    compile         kernels compiled before runs need them
    completion      completion of commands in a shell
"""
