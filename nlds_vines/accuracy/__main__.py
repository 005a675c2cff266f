"""`python -m nlds_vines.accuracy`."""

from nlds_vines.accuracy.command import main

raise SystemExit(main())
