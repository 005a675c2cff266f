"""A map in a browser: click a cell and see its orbit, or send the map as one page.

In reading order:

    map_data           the results of all cells
    map_view           images of them, legends, a cell in words
    live_orbit         one orbit: arrays of its panels, words, files
    page_state         the state of a page; parts of maps, orbits and kernels, in the background
    figures            Bokeh figures, and the frame of all pages
    live_page          the page of `explore` and its callbacks
    page_server        its local server: address, token, end
    report_page        the page of `report`, which needs no server
    command            `nlds-vines explore`
    report             `nlds-vines report`
    assets/            style, scripts and frame of the pages
"""
