"""Explore a map: click a cell and see its orbit, live in a browser; or send it as one page.

In reading order:

    map_data           what an archive, or a scan under way, holds of every cell, as plain arrays
    map_view           what a map or a diagram shows: choices, painted cells, legends, words
    live_orbit         one orbit, its verdict and all panels of it, as arrays and in words
    map_computation    a part of a map computed finer, in the background
    recipes            what one sees as a portrait recipe, a scan file, a command line
    shared_map         what the command was given, shared by all pages
    chosen             what is chosen on a page: map, cell, start, parameters
    figures            the Bokeh figures of a page, and the frame of all pages
    live_page          one browser's page: its widgets, and what happens when one is used
    local_port         the port of the server, on this machine alone
    page_server        the local server: its address, its token, its end
    command            `python -m nlds_vines.explore`
    report/            the map as one file that needs no server
    assets/            style, scripts and frame of the pages
"""
