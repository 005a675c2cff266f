"""Workers of `--scheduler local:N`: on this machine alone, deaf to those without a certificate."""

import socket
import ssl
from importlib.util import find_spec

import pytest

from nlds_vines.scans import cluster

psutil = pytest.importorskip("psutil")  # distributed brings it
pytestmark = pytest.mark.skipif(
    find_spec("distributed") is None, reason="distributed is not installed"
)
PAGE = b"GET /info/main/workers.html HTTP/1.0\r\n\r\n"
WAIT = 3.0  # s for an answer


def listening():
    """Return the addresses at which this process and those that it has started listen."""
    here = psutil.Process()
    connections = [p.net_connections("inet") for p in (here, *here.children(recursive=True))]
    return {c.laddr for each in connections for c in each if c.status == psutil.CONN_LISTEN}


def answer_to(address, text, encrypted):
    """Return the answer to a client without a certificate; empty where the line is cut."""
    context = ssl.create_default_context()
    context.check_hostname, context.verify_mode = False, ssl.CERT_NONE
    cut = (ssl.SSLError, ConnectionError, TimeoutError) if encrypted else ConnectionError
    with socket.create_connection(address, WAIT) as line:
        try:
            with context.wrap_socket(line) if encrypted else line as channel:
                channel.sendall(text)
                return channel.recv(100)
        except cut:
            return b""


@pytest.mark.slow("a scheduler and its workers")
def test_nobody_without_the_certificate_of_the_run_is_answered():
    import distributed

    before = listening()
    with cluster._client("local:1", 1) as client:
        assert client.submit(sum, [1, 2]).result(timeout=60) == 3
        addresses = listening() - before
        assert len(addresses) >= 3  # of the scheduler, the nanny and the worker
        assert {address.ip for address in addresses} == {"127.0.0.1"}
        for address in addresses:
            assert answer_to(address, PAGE, encrypted=False)[:12] in (b"", b"HTTP/1.1 404")
            assert answer_to(address, b"hello", encrypted=True) == b""
        place = client.scheduler.address
        assert place.startswith("tls://127.0.0.1:")
        with pytest.raises(OSError, match="TCP"):
            distributed.Client(place.replace("tls", "tcp"), timeout=2, set_as_default=False)
        stranger = cluster._security()
        with pytest.raises((OSError, ssl.SSLError)):
            distributed.Client(place, timeout=2, security=stranger, set_as_default=False)


def test_an_address_without_a_certificate_and_what_makes_none_are_refused(monkeypatch, error_of):
    line = error_of(cluster._client("tls://127.0.0.1:9", None).__enter__)
    assert "'tls://127.0.0.1:9' cannot be reached" in line
    one, other = (cluster._security().tls_client_cert for _ in range(2))
    assert "BEGIN CERTIFICATE" in one
    assert one != other

    def without_cryptography():
        raise ImportError

    monkeypatch.setattr("distributed.security.Security.temporary", without_cryptography)
    line = error_of(cluster._security)
    assert "certificate" in line
    assert "nlds-vines[cluster]" in line
