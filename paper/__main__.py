"""`python -m paper`."""

import sys

from paper.command import main

sys.exit(main())
