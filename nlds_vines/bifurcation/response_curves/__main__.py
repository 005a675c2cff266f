"""`python -m nlds_vines.bifurcation.response_curves`."""

import sys

from nlds_vines.bifurcation.response_curves.command import main

sys.exit(main())
