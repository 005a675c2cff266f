"""The command of the catalogue: `python -m benchmarks.extremes`."""

import sys

from benchmarks.extremes.command import main

sys.exit(main())
