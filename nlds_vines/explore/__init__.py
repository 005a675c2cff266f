"""A map in a browser: click a cell and see its orbit, or send the map as one page.

Modules in reading order: map_data, map_view, live_orbit, page_state, figures, live_page,
page_server, report_page, system_drawing, sent_page, assets.  Its commands are `upkeep.explore` and
`upkeep.report`.
"""
