"""`python -m benchmarks.stiffness`."""

import sys

from benchmarks.stiffness.command import main

sys.exit(main())
