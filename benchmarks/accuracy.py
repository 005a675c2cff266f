"""Error against run time with every rival that is installed; options as `nlds_vines.accuracy`.

    python -m benchmarks.accuracy --want 1e-6
    python -m benchmarks.accuracy --suite --plot docs/accuracy.png --markdown docs/accuracy.md

The rivals of `benchmarks/rivals` are measured beside our methods, naive RK4 and SciPy.
"""

from __future__ import annotations

import sys

from benchmarks.rivals import RIVALS
from nlds_vines.accuracy.command import command

if __name__ == "__main__":
    sys.exit(command(RIVALS, "benchmarks.accuracy").main())
