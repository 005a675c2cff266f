"""The same as `cli.command`."""

from nlds_vines.cli.command import Command as Command
from nlds_vines.cli.terminal import DIFFERENT as DIFFERENT
from nlds_vines.cli.terminal import DONE as DONE
from nlds_vines.cli.terminal import LANES_FAILED as LANES_FAILED
from nlds_vines.cli.terminal import WRONG_REQUEST as WRONG_REQUEST
from nlds_vines.cli.terminal import complain as complain
from nlds_vines.cli.terminal import ended as ended
from nlds_vines.cli.terminal import say as say
