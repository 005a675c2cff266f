"""Scans over the starts of an oscillator with a rigid stop, on which two attractors coexist."""

AMPLITUDE = 0.6  # between the fold, 0.391, and grazing, 1.259
PLANE = {
    "title": "a plane",
    "system": "impact-oscillator",
    "set": {"omega": 1.5, "P": AMPLITUDE},
    "vary": {
        "x_0": {"start": -2.0, "stop": 1.0, "num": 24},
        "v_0": {"start": -3.0, "stop": 3.0, "num": 20},
    },
    "start": {"policy": "rest"},
    "record": {"want": ["attractor"]},
}
ALONG = {
    **PLANE,
    "title": "along the amplitude",
    "set": {"omega": 1.5},
    "vary": {
        "P": {"start": 0.3, "stop": 0.6, "num": 4},
        "v_0": {"start": -3.0, "stop": 3.0, "num": 30},
    },
}
