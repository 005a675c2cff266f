"""`python -m nlds_vines.bifurcation`."""

import sys

from nlds_vines.bifurcation.command import main

sys.exit(main())
