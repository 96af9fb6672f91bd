"""The dashboard's server: loopback, its own page alone, no way to files or to the internet."""

from __future__ import annotations

import socket
import urllib.error
import urllib.request

import pytest

pytest.importorskip("viser", reason="viser is not installed")

import viser
from viser import _messages
from websockets.exceptions import ConnectionClosed
from websockets.sync.client import connect
from websockets.typing import Subprotocol

from circumspect.errors import InputError
from circumspect.viewer.guarded_server import address, guarded_server, own_page, stop

PROTOCOL = [Subprotocol(f"viser-v{viser.__version__}")]


@pytest.fixture(scope="module")
def server():
    started = guarded_server("127.0.0.1", 0)
    yield started
    stop(started)


def talks(server, **headers) -> bool:
    """Whether a browser with such headers gets anything."""
    port = server.get_port()
    with connect(
        f"ws://127.0.0.1:{port}", subprotocols=PROTOCOL, open_timeout=10,
        origin=headers.get("Origin"), user_agent_header=None, proxy=None,
    ) as channel:  # fmt: skip
        try:
            return bool(channel.recv(timeout=5))
        except ConnectionClosed:
            return False


def test_it_is_bound_to_loopback_and_says_nothing(capsys):
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


def test_a_taken_port_is_told(server):
    with pytest.raises(InputError, match="another port"):
        guarded_server("127.0.0.1", server.get_port())


@pytest.mark.parametrize("port", [-1, 65536])
def test_a_port_that_is_none_is_told(port):
    with pytest.raises(InputError, match="port"):
        guarded_server("127.0.0.1", port)


def test_an_address_of_another_machine_is_told():
    with pytest.raises(InputError, match="no dashboard there"):
        guarded_server("192.0.2.1", 0)


def test_its_own_page_may_talk_and_a_page_of_another_site_may_not(server):
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
        ({"Host": "robot:80", "Origin": "http://robot:80"}, "0.0.0.0", True),
        ({"Host": "robot:80", "Origin": "http://evil.example"}, "0.0.0.0", False),
        ({}, "127.0.0.1", False),
    ],
)
def test_whose_page_it_is(headers, host, own):
    assert own_page(headers, host) is own


def test_no_file_can_be_had_by_its_path(server):
    for path in ("/../../_viser.py", "/%2e%2e/%2e%2e/_viser.py", "/etc/passwd"):
        request = f"{address(server, '127.0.0.1')}{path}"
        with pytest.raises(urllib.error.HTTPError, match="404"):
            urllib.request.urlopen(request, timeout=10)


def test_nothing_listens_to_sharing_and_sending_of_files(server):
    listening = server._websock_server._incoming_handlers
    for kind in (
        _messages.ShareUrlRequest, _messages.ShareUrlDisconnect,
        _messages.FileTransferStartUpload, _messages.FileTransferPart,
    ):  # fmt: skip
        assert kind not in listening
