"""Figure 6: from the request file beside this script, in the current folder."""

import sys
from pathlib import Path

from nlds_vines.__main__ import main

if __name__ == "__main__":
    request = Path(__file__).with_suffix(".toml")
    picture = request.with_suffix(".png").name
    sys.exit(main(["response-curves", str(request), "--resume", "--plot", picture, *sys.argv[1:]]))
