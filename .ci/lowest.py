#!/usr/bin/env python3
"""Prints the lowest versions of all dependencies that a pyproject.toml allows, for pip."""

import sys
import tomllib
from pathlib import Path

for line in tomllib.loads(Path(sys.argv[1]).read_text())["project"]["dependencies"]:
    name, lowest = line.split(">=")
    print(f"{name}=={lowest.split(',')[0]}")
