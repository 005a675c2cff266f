"""Explore a map: click a cell and see its orbit, live in a browser; or send it as one page.

In reading order:

    map_data           what an archive, or a scan under way, holds of every cell, as plain arrays
    map_choices        what a map or a diagram may show: regimes, shares, numbers; their colors
    cell_columns       a map as a browser takes it: numbers of its cells, titles, words, colors
    histories          time histories, settled or from the start
    live_orbit         an orbit and all that the page shows of it; computed aside, one at a time
    map_computation    a part of a map computed finer, in the background
    recipes            what one sees as a portrait recipe, a scan file, a command line
    shared_map         what the command was given, shared by all pages
    page_elements      the parts of a page that are files: style, script, frame
    map_figure         the map or diagram as a Bokeh figure
    orbit_figures      the figures of one orbit
    page_state         what is chosen on a page: map, cell, start, parameters
    answers            what a page is told: orbits and evidence in words, maps, computations
    page_document      figures, sources and sliders of a page in their frame
    session            one browser's page: what happens when something on it is used
    local_port         the port of the server, on this machine alone
    server             the local server: its address, its token, its end
    command            `python -m nlds_vines.explore`
    report/            the map as one file that needs no server
    page/              style, script and frames of the pages
"""
