"""One orbit in full on a page: time histories, phase planes, section, spectrum, and words.

In reading order:

    request         which orbit, which windows of it, which panels
    window_view     what one window shows, as numbers, and as datasets of the archive
    run             the orbit computed, window by window
    result          an archive read
    picture         the page drawn
    command         `python -m nlds_vines.portrait` and `nv.orbit_portrait`
"""
