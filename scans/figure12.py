"""Figure 12: from the request file beside this script, in the current folder."""

import sys
from pathlib import Path

from nlds_vines.__main__ import main

if __name__ == "__main__":
    request = Path(__file__).with_suffix(".toml")
    archive = request.with_suffix(".h5").name
    sys.exit(main(["portrait", str(request), "--resume", "-o", archive, *sys.argv[1:]]))
