"""Figure 9: the 3T,3 regime at 7.375 rad/s.

`python scans/figure9.py [OPTION ...]` draws figure9.png; the options are those of the command
`nlds-vines portrait`, here with the request file beside this script.
"""

import sys
from pathlib import Path

from nlds_vines.portrait.command import main

if __name__ == "__main__":
    sys.exit(main([str(Path(__file__).with_suffix(".toml")), *sys.argv[1:]]))
