"""`python -m nlds_vines.explore.report`."""

import sys

from nlds_vines.explore.report.command import main

sys.exit(main())
