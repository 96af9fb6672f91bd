"""A viser server restricted to what the dashboard needs, and checks of untrusted input."""

from __future__ import annotations

import contextlib
import inspect
import io
import ipaddress
import logging
import socket
import sys
import threading
from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Any
from urllib.parse import urlsplit

from circumspect.errors import InputError, MissingExtraError, reason_of

if TYPE_CHECKING:
    import viser

LOOPBACK = ("127.0.0.1", "localhost", "::1")
EVERYWHERE = {"0.0.0.0": "127.0.0.1", "::": "::1"}
"""Wildcard addresses and the loopback address of each."""
TITLE = "circumspect"
MOST_CONNECTIONS = 16
"""Maximum number of simultaneous connections."""
LARGEST_MESSAGE = 1 << 20
"""Maximum size of a message from a browser: clicks and camera poses [bytes]."""


def guarded_server(host: str, port: int, names: Sequence[str] = ()) -> viser.ViserServer:
    """Start a server.

    Sharing over the internet and file transfer are disabled. Connections from pages of other sites
    are rejected before the handshake.

    Args:
        host: Address to listen at.
        port: The port; 0 means any that is free.
        names: Host names that browsers may use in addition to numeric addresses and the names of
            this machine.

    Raises:
        InputError: The port is taken, or this machine does not have the address.
        MissingExtraError: viser is not installed.
    """
    try:
        import viser
    except ImportError as error:
        raise MissingExtraError("viser", "viewer") from error
    from viser import _messages

    _require_free(host, port)
    # viser prints to standard output, which a program may read.
    with contextlib.redirect_stdout(io.StringIO()), _guarded_serve(host, names):
        server = viser.ViserServer(host=host, port=port, label=TITLE, verbose=False)
    connection = server._websock_server
    for kind in (_messages.ShareUrlRequest, _messages.ShareUrlDisconnect):
        connection._incoming_handlers.pop(kind, None)
    for kind in (_messages.FileTransferStartUpload, _messages.FileTransferPart):
        connection._incoming_handlers.pop(kind, None)

    server.gui.configure_theme(
        show_logo=False, show_share_button=False, control_width="large", brand_color=(29, 78, 216)
    )
    return server


@contextlib.contextmanager
def _guarded_serve(host: str, names: Sequence[str]) -> Iterator[None]:
    """Patch the server that viser starts to reject foreign pages and to limit its input."""
    import websockets.asyncio.server as sockets

    real, started = sockets.serve, threading.Event()

    def serve(handler: Any, *place: Any, **options: Any) -> Any:
        pages = options["process_request"]

        async def process_request(connection: Any, request: Any) -> Any:
            if not own_page(request.headers, host, names):
                return connection.respond(403, "this dashboard is not reached by that name\n")
            if len(connection.server.connections) > MOST_CONNECTIONS:
                return connection.respond(503, "too many connections\n")
            found = pages(connection, request)
            return await found if inspect.isawaitable(found) else found

        limited = {**options, "process_request": process_request, "max_size": LARGEST_MESSAGE}
        started.set()
        return real(handler, *place, **limited, logger=_silent_logger())

    sockets.serve = serve  # type: ignore[assignment]
    try:
        yield
        if not started.is_set():
            raise RuntimeError("this version of viser starts its server in another way")
    finally:
        sockets.serve = real  # type: ignore[assignment]


def _silent_logger() -> logging.Logger:
    """A logger that discards the tracebacks of failed connections, which are no errors here."""
    logger = logging.getLogger("circumspect.viewer.connections")
    logger.propagate = False
    logger.addHandler(logging.NullHandler())
    return logger


def own_page(headers: Any, host: str, names: Sequence[str] = ()) -> bool:
    """Whether a connection comes from the dashboard's own page, or not from a browser.

    The Host must be a numeric address, a name of this machine, or an allowed name. This prevents
    DNS rebinding.

    Args:
        headers: Headers of the request: Host and, from a browser, Origin.
        host: Address of the server; on loopback only the loopback names are accepted.
        names: Additional allowed names.
    """
    hosts = headers.get_all("Host") if hasattr(headers, "get_all") else [headers.get("Host", "")]
    origins = (
        headers.get_all("Origin")
        if hasattr(headers, "get_all")
        else [value for value in [headers.get("Origin")] if value is not None]
    )
    if len(hosts) != 1 or len(origins) > 1:
        return False
    (named,) = hosts
    try:
        hostname = urlsplit(f"//{named}").hostname or ""
        from_own = not origins or urlsplit(origins[0]).netloc.lower() == named.lower()
    except ValueError:
        return False
    allowed = {name.lower() for name in (host, *names)}
    if host not in LOOPBACK:
        own = socket.gethostname().lower()
        allowed |= {own, own.partition(".")[0], f"{own.partition('.')[0]}.local"}
    is_known = hostname in LOOPBACK or hostname in allowed
    if not is_known and host not in LOOPBACK:
        is_known = _is_address(hostname)
    return is_known and from_own


def _is_address(name: str) -> bool:
    """Whether a name is a numeric address."""
    try:
        ipaddress.ip_address(name)
    except ValueError:
        return False
    return True


def address(server: viser.ViserServer, host: str) -> str:
    """URL of the server for a browser on this machine."""
    name = EVERYWHERE.get(host, host)
    shown = f"[{name}]" if ":" in name else name
    return f"http://{shown}:{server.get_port()}"


def stop(server: viser.ViserServer) -> None:
    """Stop the server without output."""
    with contextlib.redirect_stdout(io.StringIO()):
        server.stop()
    sys.stdout.flush()


def _require_free(host: str, port: int) -> None:
    """Check that the port is free; viser would silently use the next one."""
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


def clipped(value: Any, low: float, high: float) -> float:
    """An untrusted value as a number within bounds."""
    if isinstance(value, bool) or not isinstance(value, int | float) or not low <= value <= high:
        return low
    return float(value)
