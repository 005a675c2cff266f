"""What a user would choose instead: other people's solvers, each used well and plainly.

All of them solve eq. (5) in its own variables x1, v1, x2, v2 and share no formula with the kernels.
A peer whose package is not installed is listed all the same; nothing imports it before it is used.
"""

from nlds_vines.peers import (
    diffrax_solvers,
    heyoka_taylor,
    numbalsoda_solvers,
    octave,
    plain,
    scipy_solvers,
    sundials,
)
from nlds_vines.peers.base import Course, Flow, Peer, PeerFailure
from nlds_vines.peers.equation import constants, derivative

PEERS: tuple[Peer, ...] = (
    *plain.PEERS,
    *scipy_solvers.PEERS,
    *numbalsoda_solvers.PEERS,
    *heyoka_taylor.PEERS,
    *sundials.PEERS,
    *diffrax_solvers.PEERS,
    *octave.PEERS,
)
"""All of them, whether installed or not."""


def installed() -> tuple[Peer, ...]:
    """Return the peers whose packages are installed."""
    return tuple(peer for peer in PEERS if peer.available())


__all__ = ["PEERS", "Course", "Flow", "Peer", "PeerFailure", "constants", "derivative", "installed"]
