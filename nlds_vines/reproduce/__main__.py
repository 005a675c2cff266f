"""`python -m nlds_vines.reproduce`."""

import sys

from nlds_vines.reproduce.command import main

sys.exit(main())
