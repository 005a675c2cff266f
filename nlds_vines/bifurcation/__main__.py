"""`python -m nlds_vines.bifurcation`."""

from nlds_vines.bifurcation.command import main

raise SystemExit(main())
