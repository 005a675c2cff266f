"""`python -m nlds_vines.accuracy`."""

import sys

from nlds_vines.accuracy.command import main

sys.exit(main())
