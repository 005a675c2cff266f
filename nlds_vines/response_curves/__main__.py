"""`python -m nlds_vines.response_curves`."""

import sys

from nlds_vines.response_curves.command import main

sys.exit(main())
