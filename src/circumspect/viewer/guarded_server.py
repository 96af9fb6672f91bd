"""viser's server with everything shut that a dashboard on a robot does not need."""

from __future__ import annotations

import contextlib
import io
import logging
import socket
import sys
from typing import TYPE_CHECKING, Any
from urllib.parse import urlsplit

from circumspect.errors import InputError, MissingExtraError, reason_of

if TYPE_CHECKING:
    import viser

LOOPBACK = ("127.0.0.1", "localhost", "::1")
EVERYWHERE = {"0.0.0.0": "127.0.0.1", "::": "::1"}
"""Addresses that are all of a machine's to the one by which it reaches itself."""
TITLE = "circumspect"


def guarded_server(host: str, port: int) -> viser.ViserServer:
    """Start a server.

    Sharing over the internet and sending of files are taken out, whatever a browser asks for. A
    page of another site that a browser shows can not talk to the dashboard behind its back.

    Args:
        host: Address to listen at.
        port: The port; 0 means any that is free.

    Raises:
        InputError: The port is taken, or this machine has no such address.
        MissingExtraError: viser is not installed.
    """
    try:
        import viser
    except ImportError as error:
        raise MissingExtraError("viser", "viewer") from error
    from viser import _messages

    _require_free(host, port)
    logging.getLogger("websockets.server").addFilter(_is_no_failed_handshake)
    # viser announces itself on standard output, which may be meant for a program.
    with contextlib.redirect_stdout(io.StringIO()):
        server = viser.ViserServer(host=host, port=port, label=TITLE, verbose=False)
    connection = server._websock_server
    for kind in (_messages.ShareUrlRequest, _messages.ShareUrlDisconnect):
        connection._incoming_handlers.pop(kind, None)
    for kind in (_messages.FileTransferStartUpload, _messages.FileTransferPart):
        connection._incoming_handlers.pop(kind, None)

    @connection.on_client_connect
    async def _(client: Any) -> None:
        live = connection._live_connections.get(client.client_id)
        headers = {} if live is None or live.request is None else live.request.headers
        if live is not None and not own_page(headers, host):
            await live.close(1008, "a page of another site")

    server.gui.configure_theme(
        show_logo=False, show_share_button=False, control_width="large", brand_color=(29, 78, 216)
    )
    return server


def own_page(headers: Any, host: str) -> bool:
    """Whether a connection comes from the dashboard's own page, or from no browser at all.

    Args:
        headers: Of the request: Host and, where a browser made it, Origin.
        host: Where the server listens. On loopback it has the names of this machine only, so that
            a name that somebody else points at this machine opens nothing.
    """
    named = headers.get("Host", "")
    if host in LOOPBACK and urlsplit(f"//{named}").hostname not in LOOPBACK:
        return False
    origin = headers.get("Origin")
    return origin is None or urlsplit(origin).netloc == named


def address(server: viser.ViserServer, host: str) -> str:
    """What to type into a browser on this machine."""
    name = EVERYWHERE.get(host, host)
    shown = f"[{name}]" if ":" in name else name
    return f"http://{shown}:{server.get_port()}"


def stop(server: viser.ViserServer) -> None:
    """Stop without a word."""
    with contextlib.redirect_stdout(io.StringIO()):
        server.stop()
    sys.stdout.flush()


def _is_no_failed_handshake(record: logging.LogRecord) -> bool:
    """A browser that connects ahead, or a check of the port, sends no request: that is no fault."""
    return record.getMessage() != "opening handshake failed"


def _require_free(host: str, port: int) -> None:
    """Viser would take the next port without a word."""
    if not 0 <= port <= 65535:
        raise InputError(f"--viewer-port {port}: a port is from 0 to 65535")
    family = socket.AF_INET6 if ":" in host else socket.AF_INET
    try:
        with socket.socket(family, socket.SOCK_STREAM) as trial:
            trial.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
            trial.bind((host, port))
    except OSError as error:
        raise InputError(
            f"{host}:{port}: no dashboard there ({reason_of(error)}); give another port, 0 for any"
        ) from error
