"""A server on loopback that sends an archive, with faults on request."""

import gzip
import io
import zipfile
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer

OFF = b"OFF\n4 4 0\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 1 2\n3 0 1 3\n3 0 2 3\n3 1 2 3\n"

FAR_TOO_OFTEN = 30
"""A bound on requests: a test of an endless download fails."""


def archive(
    names=("ModelNet10/chair/train/chair_0001.off", "ModelNet10/bed/test/bed_0516.off"),
    compression=zipfile.ZIP_STORED,
):
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w", compression) as members:
        for name in (*names, "__MACOSX/ModelNet10/._chair", "../outside.off"):
            members.writestr(name, OFF * 4000)
    return stream.getvalue()


class Server(ThreadingHTTPServer):
    """Serves one file, with faults on request."""

    def __init__(self):
        super().__init__(("127.0.0.1", 0), Handler)
        self.content, self.version, self.status = archive(), '"1"', 200
        self.breaks_off_after: int | None = None
        self.refuses_ranges = self.packs = False
        self.length: str | None = None
        self.part_is_called = "bytes {first}-{last}/{total}"
        self.part_starts_off = 0
        self.sends_at_most: int | None = None
        self.asked: list[str | None] = []

    @property
    def url(self):
        return f"http://127.0.0.1:{self.server_address[1]}/ModelNet10.zip"


class Handler(BaseHTTPRequestHandler):
    server: Server

    def do_GET(self):
        server, asked = self.server, self.headers.get("Range")
        server.asked.append(asked)
        if server.status != 200 or len(server.asked) > FAR_TOO_OFTEN:
            self.send_error(server.status if server.status != 200 else 503)
            return
        first, same = 0, self.headers.get("If-Range") == server.version
        if asked and same:
            first = int(asked.removeprefix("bytes=").removesuffix("-"))
        if asked and server.refuses_ranges:
            self.send_error(416)
            return
        if first:
            first += server.part_starts_off
        body = server.content[first:][: server.sends_at_most]
        self.send_response(206 if first else 200)
        if first:
            last, total = first + len(body) - 1, len(server.content)
            span = server.part_is_called.format(first=first, last=last, total=total)
            self.send_header("Content-Range", span)
        if server.packs:
            body = gzip.compress(body)
            self.send_header("Content-Encoding", "gzip")
        self.send_header("Content-Length", server.length or str(len(body)))
        self.send_header("ETag", server.version)
        self.end_headers()
        self.wfile.write(body[: server.breaks_off_after])

    def log_message(self, *words):
        pass
