"""The command of the mutants: `python -m benchmarks.mutants`."""

import sys

from benchmarks.mutants.command import main

sys.exit(main())
