"""`python -m nlds_vines.transients`."""

from nlds_vines.transients.command import main

raise SystemExit(main())
