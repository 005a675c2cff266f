"""`python -m nlds_vines.tuning`."""

import sys

from nlds_vines.tuning.command import main

sys.exit(main())
