"""Numbers in, numbers out: flight, touch, contact, orbit. Compiled; no I/O, no plotting."""
