"""The local server: token, host and origin; a busy port; how it ends."""

import contextlib
import http.client
import signal

import pytest

from benchmarks.explore import Served
from nlds_vines.__main__ import main

pytest.importorskip("bokeh", reason="Bokeh is not installed")

from nlds_vines.explore.local_port import listening


class Asked(Served):
    """The command in a process of its own, asked as a browser would, or a page of others."""

    def __init__(self, *arguments):
        super().__init__(*map(str, arguments))
        _, _, self.host, self.token, _ = self.address.split("/")
        self.port = int(self.host.rpartition(":")[2])

    def get(self, path, **headers):
        headers.setdefault("Host", self.host)
        connection = http.client.HTTPConnection("127.0.0.1", self.port, timeout=30)
        with contextlib.closing(connection):
            connection.putrequest("GET", path, skip_host=True)
            for name, value in headers.items():
                connection.putheader(name.replace("_", "-"), value)
            connection.endheaders()
            answer = connection.getresponse()
            with contextlib.closing(answer):
                text = "" if answer.status == 101 else answer.read().decode()
                return answer.status, text


@pytest.fixture(scope="module")
def server(small_map):
    running = Asked(small_map)
    yield running
    running.end(signal.SIGKILL)


def test_the_page_is_there_with_its_token(server):
    status, text = server.get(f"/{server.token}/")
    assert status == 200
    assert "a small map" in text
    assert server.address.startswith("http://127.0.0.1:")
    assert len(server.token) >= 32


@pytest.mark.parametrize(
    "path", ["/", "/x/", "/static/js/bokeh.min.js", "/ws", "/{token}x/", "/favicon.ico"]
)
def test_without_the_token_everything_is_refused(server, path):
    status, text = server.get(path.replace("{token}", server.token))
    assert status == 403
    assert "refused" in text


@pytest.mark.parametrize("host", ["evil.example", "localhost:{port}", "127.0.0.1"])
def test_under_another_name_everything_is_refused(server, host):
    assert server.get(f"/{server.token}/", Host=host.replace("{port}", str(server.port)))[0] == 403


SOCKET = {
    "Upgrade": "websocket", "Connection": "Upgrade", "Sec_WebSocket_Version": "13",
    "Sec_WebSocket_Key": "dGhlIHNhbXBsZSBub25jZQ==",
}  # fmt: skip


@pytest.mark.parametrize(
    "origin", ["http://evil.example", "null", "http://127.0.0.1:1", "https://{host}"]
)
@pytest.mark.parametrize("path", ["", "ws"])
def test_from_another_origin_everything_is_refused(server, origin, path):
    headers = SOCKET if path else {}
    status, _ = server.get(
        f"/{server.token}/{path}", Origin=origin.replace("{host}", server.host), **headers
    )
    assert status == 403


def test_the_socket_opens_for_the_page_itself(server):
    headers = {**SOCKET, "Origin": f"http://{server.host}"}
    assert server.get(f"/{server.token}/ws", **headers)[0] == 101


def test_no_file_is_served(server):
    for path in ("static/../../../../etc/passwd", "static/%2e%2e/%2e%2e/server.py", "map.h5"):
        assert server.get(f"/{server.token}/{path}")[0] in (403, 404)


def test_it_listens_on_this_machine_alone():
    with contextlib.closing(listening(0)) as place:
        assert place.getsockname()[0] == "127.0.0.1"


@pytest.mark.parametrize(("number", "status"), [(signal.SIGINT, 130), (signal.SIGTERM, 143)])
def test_a_signal_ends_it(number, status, small_map):
    running = Asked(small_map)
    assert running.get(f"/{running.token}/")[0] == 200
    found, errors = running.end(number)
    assert found == status
    assert errors == ""


def test_a_busy_port_is_one_line(server, small_map, capsys):
    assert main(["explore", str(small_map), "--no-browser", "--port", str(server.port)]) == 2
    found = capsys.readouterr().err
    assert found.count("\n") == 1
    assert f"--port {server.port}" in found


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["no.h5"], "no.h5"),
        (["no.toml"], "no.toml"),
        (["--system", "nothing"], "nothing"),
        (["--port", "70000"], "--port"),
        (["map.h5", "--set", "P=3"], "--set"),
    ],
)
def test_a_wrong_request_is_one_line(arguments, words, capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert main(["explore", *arguments]) == 2
    found = capsys.readouterr().err
    assert found.count("\n") == 1
    assert words in found


@pytest.mark.parametrize("name", ["ssul-set6", "vi-nes", "none", "bouncing-ball", "ssbl"])
def test_every_system_has_a_diagram_to_explore(name, capsys):
    assert main(["explore", "--system", name, "--dry-run"]) == 0
    assert "401 cells" in capsys.readouterr().out
