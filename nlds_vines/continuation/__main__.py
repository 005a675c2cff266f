"""`python -m nlds_vines.continuation`."""

from nlds_vines.continuation.command import main

raise SystemExit(main())
