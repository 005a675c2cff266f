"""`python -m nlds_vines.continuation`."""

import sys

from nlds_vines.continuation.command import main

sys.exit(main())
