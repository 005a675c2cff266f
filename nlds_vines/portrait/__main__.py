"""`python -m nlds_vines.portrait`."""

import sys

from nlds_vines.portrait.command import main

sys.exit(main())
