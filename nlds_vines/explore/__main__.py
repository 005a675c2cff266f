"""`python -m nlds_vines.explore`."""

from nlds_vines.explore.command import main

raise SystemExit(main())
