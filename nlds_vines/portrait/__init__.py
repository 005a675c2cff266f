"""One orbit in full on a page: time histories, phase planes, section, spectrum, and words.

In reading order:

    request         which orbit, which windows of it, which panels
    result          windows of orbits as numbers, their archive
    run             the orbit computed, window by window
    panels          each panel drawn
    picture         the page
    command         `python -m nlds_vines.portrait` and `nv.orbit_portrait`
"""
