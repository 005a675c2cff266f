"""Figure 5: from the request file beside this script, in the current folder."""

import sys
from pathlib import Path

from nlds_vines.__main__ import main

if __name__ == "__main__":
    request = str(Path(__file__).with_suffix(".toml"))
    sys.exit(main(["response-curves", request, "--resume", *sys.argv[1:]]))
