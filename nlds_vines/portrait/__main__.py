"""`python -m nlds_vines.portrait`."""

from nlds_vines.portrait.command import main

raise SystemExit(main())
