"""The dashboard's server: loopback, its own page alone, no way to files or to the internet."""

from __future__ import annotations

import logging
import socket
import time
import urllib.error
import urllib.request
from contextlib import suppress
from types import SimpleNamespace

import pytest

pytest.importorskip("viser", reason="viser is not installed")

import viser
from viser import _messages
from websockets.exceptions import ConnectionClosed, InvalidStatus
from websockets.sync.client import connect
from websockets.typing import Subprotocol

from circumspect.errors import InputError
from circumspect.viewer.guarded_server import (
    LARGEST_MESSAGE,
    address,
    guarded_server,
    own_page,
    stop,
)

PROTOCOL = [Subprotocol(f"viser-v{viser.__version__}")]


@pytest.fixture(scope="module")
def server():
    started = guarded_server("127.0.0.1", 0)
    yield started
    stop(started)


def talks(server, **headers) -> bool:
    """Whether the server answers a browser with these headers."""
    try:
        with connected(server, **headers) as channel:
            return bool(channel.recv(timeout=20))
    except InvalidStatus as rejected:
        return rejected.response.status_code != 403


def connected(server, **headers):
    return connect(
        f"ws://127.0.0.1:{server.get_port()}", subprotocols=PROTOCOL, open_timeout=20,
        origin=headers.get("Origin"), user_agent_header=None, proxy=None,
    )  # fmt: skip


def test_the_server_binds_to_loopback_and_prints_nothing(capsys):
    server = guarded_server("127.0.0.1", 0)
    try:
        bound = server._websock_server._port
        assert address(server, "127.0.0.1") == f"http://127.0.0.1:{bound}"
        with socket.socket() as other:
            other.bind(("127.0.0.2", bound))  # Free: the server is not bound to all addresses.
        with urllib.request.urlopen(address(server, "127.0.0.1"), timeout=10) as page:
            assert b"<html" in page.read().lower()
    finally:
        stop(server)
    assert capsys.readouterr().out == ""


@pytest.mark.parametrize("host", ["::1", "::"])
def test_ipv6_addresses_can_be_reached(host):
    try:
        socket.create_server(("::1", 0), family=socket.AF_INET6).close()
    except OSError:
        pytest.skip("this machine has no IPv6")
    server = guarded_server(host, 0)
    try:
        with urllib.request.urlopen(address(server, host), timeout=10) as page:
            assert page.status == 200
    finally:
        stop(server)


@pytest.mark.parametrize(
    ("host", "shown"),
    [
        ("127.0.0.1", "127.0.0.1"), ("localhost", "localhost"), ("0.0.0.0", "127.0.0.1"),
        ("10.0.0.7", "10.0.0.7"), ("::1", "[::1]"), ("::", "[::1]"), ("fd00::2", "[fd00::2]"),
    ],
)  # fmt: skip
def test_the_printed_address_opens_in_a_browser(host, shown):
    assert address(SimpleNamespace(get_port=lambda: 80), host) == f"http://{shown}:80"


def test_empty_and_invalid_connections_are_not_logged(monkeypatch, caplog):
    monkeypatch.setattr(logging.getLogger("websockets.server"), "filters", [])
    server = guarded_server("127.0.0.1", 0)
    try:
        for words in (b"", b"nonsense\r\n\r\n"):
            with socket.create_connection(("127.0.0.1", server.get_port())) as asker:
                asker.sendall(words)
                asker.shutdown(socket.SHUT_WR)
                while asker.recv(4096):  # Until the server closes the connection.
                    pass
        time.sleep(0.2)
    finally:
        stop(server)
    assert [record for record in caplog.records if record.name.startswith("websockets")] == []


def test_a_taken_port_is_refused(server):
    with pytest.raises(InputError, match="another port"):
        guarded_server("127.0.0.1", server.get_port())


@pytest.mark.parametrize("port", [-1, 65536])
def test_an_invalid_port_is_refused(port):
    with pytest.raises(InputError, match="port"):
        guarded_server("127.0.0.1", port)


def test_an_address_of_another_machine_is_refused():
    with pytest.raises(InputError, match="no dashboard there"):
        guarded_server("192.0.2.1", 0)


def test_connections_of_other_origins_are_rejected(server):
    port = server.get_port()
    assert talks(server, Origin=f"http://127.0.0.1:{port}")
    assert talks(server)
    assert not talks(server, Origin="https://elsewhere.example")
    assert not talks(server, Origin=f"http://127.0.0.1:{port + 1}")
    assert not talks(server, Origin="null")


@pytest.mark.parametrize(
    ("headers", "host", "own"),
    [
        ({"Host": "127.0.0.1:80", "Origin": "http://127.0.0.1:80"}, "127.0.0.1", True),
        ({"Host": "localhost:80", "Origin": "http://localhost:80"}, "127.0.0.1", True),
        ({"Host": "[::1]:80", "Origin": "http://[::1]:80"}, "::1", True),
        ({"Host": "evil.example:80", "Origin": "http://evil.example:80"}, "127.0.0.1", False),
        ({"Host": "robot:80", "Origin": "http://robot:80"}, "0.0.0.0", False),
        ({"Host": "10.0.0.7:80", "Origin": "http://10.0.0.7:80"}, "0.0.0.0", True),
        ({"Host": "[fd00::2]:80", "Origin": "http://[fd00::2]:80"}, "::", True),
        ({"Host": "10.0.0.7:80"}, "127.0.0.1", False),
        ({"Host": "Allowed.example:80", "Origin": "http://allowed.example:80"}, "0.0.0.0", True),
        ({"Host": "[:80"}, "0.0.0.0", False),
        ({"Host": f"{socket.gethostname()}:80"}, "0.0.0.0", True),
        ({"Host": "robot:80", "Origin": "http://evil.example"}, "0.0.0.0", False),
        ({}, "127.0.0.1", False),
    ],
)
def test_own_page_checks_host_and_origin(headers, host, own):
    assert own_page(headers, host, ("allowed.example",)) is own


def test_dns_rebinding_is_rejected(server):
    request = urllib.request.Request(
        address(server, "127.0.0.1"), headers={"Host": "rebound.example"}
    )
    with pytest.raises(urllib.error.HTTPError, match="403"):
        urllib.request.urlopen(request, timeout=20)


def test_too_large_messages_close_the_connection_silently(server, caplog, capsys):
    with connected(server) as channel:
        channel.recv(timeout=20)
        channel.send(bytes(LARGEST_MESSAGE + 1))
        with suppress(ConnectionClosed):
            while channel.recv(timeout=20):
                pass
    assert "Traceback" not in capsys.readouterr().err + caplog.text


def test_connections_are_limited(server, monkeypatch):
    monkeypatch.setattr("circumspect.viewer.guarded_server.MOST_CONNECTIONS", 1)
    with connected(server) as first, connected(server) as second:
        first.recv(timeout=20)
        second.recv(timeout=20)
        with pytest.raises(InvalidStatus, match="503"):
            connected(server).__enter__()


def test_path_traversal_is_rejected(server):
    for path in ("/../../_viser.py", "/%2e%2e/%2e%2e/_viser.py", "/etc/passwd"):
        request = f"{address(server, '127.0.0.1')}{path}"
        with pytest.raises(urllib.error.HTTPError, match="404"):
            urllib.request.urlopen(request, timeout=10)


def test_share_and_upload_handlers_are_removed(server):
    listening = server._websock_server._incoming_handlers
    for kind in (
        _messages.ShareUrlRequest, _messages.ShareUrlDisconnect,
        _messages.FileTransferStartUpload, _messages.FileTransferPart,
    ):  # fmt: skip
        assert kind not in listening
