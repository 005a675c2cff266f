"""`python -m nlds_vines.loads`."""

from nlds_vines.loads.command import main

raise SystemExit(main())
