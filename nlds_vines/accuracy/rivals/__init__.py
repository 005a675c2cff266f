"""What a user would choose instead: other people's solvers, each used well and plainly.

All of them solve eq. (5) in its own variables x1, v1, x2, v2 and share no formula with the kernels.
A peer whose package is not installed is listed all the same; nothing imports it before it is used.
"""

from nlds_vines.accuracy.rivals import plain, scipy_solvers
from nlds_vines.accuracy.rivals.equation import constants, derivative
from nlds_vines.accuracy.rivals.rival import Asked, Course, Flow, Peer, PeerFailure

PEERS: tuple[Peer, ...] = (
    *plain.PEERS,
    *scipy_solvers.PEERS,
)
"""All of them, whether installed or not."""


def installed() -> tuple[Peer, ...]:
    """Return the peers whose packages are installed."""
    return tuple(peer for peer in PEERS if peer.available())


__all__ = [
    "PEERS",
    "Asked",
    "Course",
    "Flow",
    "Peer",
    "PeerFailure",
    "constants",
    "derivative",
    "installed",
]
