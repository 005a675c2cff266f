"""`python -m nlds_vines.loads`."""

import sys

from nlds_vines.loads.command import main

sys.exit(main())
