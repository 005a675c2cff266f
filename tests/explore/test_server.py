"""The local server: token, host and origin; a busy port; how it ends."""

import contextlib
import http.client
import signal
from concurrent.futures import ThreadPoolExecutor, as_completed

import numpy as np
import pytest

import nlds_vines as nv
from benchmarks.explore import Served

pytest.importorskip("bokeh", reason="Bokeh is not installed")

from nlds_vines.explore.page_server import MOST_PAGES
from nlds_vines.upkeep.explore import listening


class Asked(Served):
    """The command in a process of its own, asked as a browser would or a foreign page."""

    def __init__(self, *arguments):
        super().__init__(*map(str, arguments))
        self.host, self.token = self.address.removeprefix("http://").split("/enter?token=")
        self.port = int(self.host.rpartition(":")[2])
        self.headers = {}

    def get(self, path, cookie=True, **headers):
        """Return status and text of an answer, whose headers are kept; with the cookie or not."""
        headers.setdefault("Host", self.host)
        if cookie:
            headers["Cookie"] = f"nlds_vines_{self.port}={self.token}"
        connection = http.client.HTTPConnection("127.0.0.1", self.port, timeout=30)
        with contextlib.closing(connection):
            fields = {name.replace("_", "-"): text for name, text in headers.items()}
            connection.request("GET", path, headers=fields)
            with contextlib.closing(connection.getresponse()) as answer:
                self.headers = dict(answer.getheaders())
                return answer.status, "" if answer.status == 101 else answer.read().decode()


class Patient(Asked):
    """The command whose pages may be left for long before they make room for others."""

    program = (
        "-c",
        "import sys; from nlds_vines import __main__; from nlds_vines.explore import page_server;"
        "page_server.LEFT_SECONDS = 600.0; sys.exit(__main__.main(sys.argv[1:]))",
    )


@pytest.fixture(scope="module")
def server(small_map):
    with Asked(small_map) as running:
        yield running
        assert running.end() == (130, "")  # not a word about what was refused


def test_the_address_leads_to_the_page_leaves_a_cookie_and_says_what_may_be_loaded(server):
    assert server.get(f"/enter?token={server.token}", cookie=False)[0] == 302
    assert server.headers["Location"] == "/"
    cookie = server.headers["Set-Cookie"]
    assert cookie.startswith(f"nlds_vines_{server.port}={server.token};")
    assert {"HttpOnly", "Path=/", "SameSite=Lax"} <= set(cookie.split("; "))
    status, text = server.get("/")
    assert status == 200
    assert "a small map" in text
    assert server.token not in text
    assert server.address.startswith("http://127.0.0.1:")
    assert len(server.token) >= 32
    # every answer says what a browser may load
    entrance = f"/enter?token={server.token}"
    for path, cookie in (("/", True), ("/", False), (entrance, False), ("/no", True)):
        server.get(path, cookie)
        policy = server.headers["Content-Security-Policy"]
        assert "default-src 'none'" in policy
        assert "frame-ancestors 'none'" in policy
        assert server.headers["X-Frame-Options"] == "DENY"
        assert server.headers["Referrer-Policy"] == "no-referrer"
        assert server.headers["X-Content-Type-Options"] == "nosniff"


SOCKET = {
    "Upgrade": "websocket", "Connection": "Upgrade", "Sec_WebSocket_Version": "13",
    "Sec_WebSocket_Key": "dGhlIHNhbXBsZSBub25jZQ==",
}  # fmt: skip


def test_what_does_not_come_from_the_page_is_refused(server):
    token, entrance = server.token, f"/enter?token={server.token}"
    # without the cookie
    for path in ("/", "/x/", "/static/js/bokeh.min.js", "/ws", "/favicon.ico"):
        for cookie in ("", f"nlds_vines_{server.port}=x", f"nlds_vines_{server.port + 1}={token}"):
            status, text = server.get(path, cookie=False, Cookie=cookie)
            assert status == 403, (path, cookie)
            assert "refused" in text
    # with tokens that are almost right
    for words in (f"={token}x", f"={token[:-1]}", "=", "", f"={token}&token=x"):
        assert server.get(f"/enter?token{words}", cookie=False)[0] == 403
    for path in (f"/{token}/", "/enter/x"):
        assert server.get(path, cookie=False)[0] == 403
    # under another name
    for host in ("evil.example", f"localhost:{server.port}", "127.0.0.1"):
        for path in ("/", entrance):
            assert server.get(path, Host=host)[0] == 403, (path, host)
    # from another origin; the socket opens for the page itself
    foreign = "http://evil.example", "null", "http://127.0.0.1:1", f"https://{server.host}"
    for origin in foreign:
        for path, headers in (("/", {}), ("/ws", SOCKET)):
            assert server.get(path, Origin=origin, **headers)[0] == 403, (path, origin)
    assert server.get("/ws", Origin=f"http://{server.host}", **SOCKET)[0] == 101
    # no file is served, and odd addresses are none
    for path in ("static/../../../../etc/passwd", "static/%2e%2e/%2e%2e/server.py", "map.h5"):
        assert server.get(f"/{path}")[0] in (403, 404)
    for path in ("%00", "static/%00", "static/js/%00.js", "a%00/", "%ff", "static/%ff", "a//b"):
        assert server.get(f"/{path}")[0] in (400, 403, 404), path


@pytest.mark.slow("a server and many pages")
def test_only_so_many_pages_are_open_at_a_time(small_map):
    with Patient(small_map) as running:
        pages = [running.get("/") for _ in range(MOST_PAGES + 2)]
        assert running.end() == (130, "")
    assert [status for status, _ in pages] == [200] * MOST_PAGES + [503] * 2
    assert f"{MOST_PAGES} pages are open" in pages[-1][1]


class Few(Asked):
    """The command with three pages at most, which may be left for long."""

    program = (
        "-c",
        "import sys; from nlds_vines import __main__; from nlds_vines.explore import page_server;"
        "page_server.LEFT_SECONDS = 600.0; page_server.MOST_PAGES = 3;"
        "sys.exit(__main__.main(sys.argv[1:]))",
    )


@pytest.mark.slow("a server and many pages")
def test_pages_that_are_asked_for_at_once_do_not_pass_the_limit(small_map):
    """None of them exists yet when the last one is asked for."""
    with Few(small_map) as running, ThreadPoolExecutor(30) as pool:
        answers = [*pool.map(lambda _: running.get("/")[0], range(30))]
        assert running.end() == (130, "")
    assert sorted(answers) == [200] * 3 + [503] * 27


@pytest.mark.slow("a server and many pages")
def test_ctrl_c_does_not_wait_for_pages_that_are_asked_for(small_map):
    with Patient(small_map) as running, ThreadPoolExecutor(MOST_PAGES) as pool:
        asked = [pool.submit(running.get, "/") for _ in range(MOST_PAGES)]
        next(as_completed(asked))
        assert running.end() == (130, "")
    answers = [answer.result()[1] for answer in asked if answer.exception() is None]
    assert 1 <= sum("a small map" in text for text in answers) < MOST_PAGES  # others are empty


def test_a_map_of_too_many_orbits_is_refused_in_one_line(here, refusal):
    vary = {"omega": np.linspace(5.0, 8.0, 10_000), "P": np.linspace(500.0, 900.0, 10_000)}
    scan = nv.load_scan("ssul-set6", {"vary": vary})
    (here / "large.toml").write_text(scan.to_toml())
    line = refusal("explore", "large.toml", "--no-browser", "--port", "0")
    assert "has 100000000 orbits; a page shows up to 4000000" in line


def test_archives_without_a_map_open_as_a_page_that_computes_nothing(here, answer, refusal):
    samples = {"k1": np.array([3.9e4, 4e4]), "C": np.array([0.06, 0.062])}
    sampling = {"transient": 10, "periods": 8}
    nv.scan("ssul-set6", samples=samples, sampling=sampling, to="samples.h5", quiet=True)
    assert "its page, as `nlds-vines report` sends it" in answer(
        "explore", "samples.h5", "--dry-run", "--port", "0"
    )
    line = refusal("explore", "samples.h5", "--frequency", "Hz", "--port", "0")
    assert "--frequency is for the page of a map" in line
    with Asked("samples.h5") as running:
        status, text = running.get("/")
        assert status == 200
        assert "varied: 2 samples of k1, C" in text
        assert "<script" not in text
        assert "default-src 'none'" in running.headers["Content-Security-Policy"]
        assert running.get("/", cookie=False)[0] == 403
        assert running.end() == (130, "")
    # they are not computed by the page
    (here / "samples.toml").write_text(nv.open_archive("samples.h5").request.to_toml())
    assert "samples have no axis" in refusal("explore", "samples.toml", "--dry-run")


def test_it_listens_on_this_machine_alone_and_a_busy_port_is_one_line(server, small_map, refusal):
    with contextlib.closing(listening(0)) as listener:
        assert listener.getsockname()[0] == "127.0.0.1"
    line = refusal("explore", small_map, "--no-browser", "--port", server.port)
    assert f"--port {server.port}" in line


def test_sigterm_ends_it(small_map):
    with Asked(small_map) as running:
        assert running.get("/")[0] == 200
        assert running.end(signal.SIGTERM) == (143, "")


@pytest.mark.parametrize("name", ["vi-nes", "none"])
def test_every_system_has_a_diagram_to_explore(name, answer):
    assert "401 cells" in answer("explore", "--system", name, "--dry-run")
