"""Figure 11: transient chaos at 7.575 rad/s, its chaotic and its periodic phase.

`python scans/figure11.py [OPTION ...]` draws figure11.png; the options are those of the command
`nlds-vines portrait`, here with the request file beside this script.
"""

import sys
from pathlib import Path

from nlds_vines.portrait.command import main

if __name__ == "__main__":
    sys.exit(main([str(Path(__file__).with_suffix(".toml")), *sys.argv[1:]]))
