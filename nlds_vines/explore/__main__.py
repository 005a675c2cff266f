"""`python -m nlds_vines.explore`."""

import sys

from nlds_vines.explore.command import main

sys.exit(main())
