"""`python -m nlds_vines.transients`."""

import sys

from nlds_vines.transients.command import main

sys.exit(main())
