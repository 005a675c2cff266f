"""The search for good dampers: request, objective, journal, methods, and what came of them."""
