"""`python -m nlds_vines.tuning`."""

from nlds_vines.tuning.command import main

raise SystemExit(main())
