"""A server of one raster on the loopback: it gives parts of it, and fails as servers do."""

from __future__ import annotations

import contextlib
import http.server
import threading
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any, Literal

FACTS = {"ETag": '"1"', "Last-Modified": "Mon, 04 May 2026 10:30:00 GMT"}
Fault = Literal["", "hangs", "whole", "cut", "missing", "cut later"]


@dataclass
class RasterServer:
    """``requests``: (method, path, Authorization) as they came. ``redirect``: where all of them are sent."""

    content: bytes
    fault: Fault = ""
    redirect: str = ""
    port: int = 0
    requests: list[tuple[str, str, str]] = field(default_factory=list)
    ended: threading.Event = field(default_factory=threading.Event)

    @property
    def at(self) -> str:
        return f"127.0.0.1:{self.port}"


@contextlib.contextmanager
def raster_server(content: bytes, fault: Fault = "", redirect: str = "") -> Iterator[RasterServer]:
    state = RasterServer(content, fault, redirect)

    class Handler(http.server.BaseHTTPRequestHandler):
        protocol_version = "HTTP/1.1"

        def do_GET(self) -> None:
            state.requests.append((self.command, self.path, self.headers.get("Authorization", "")))
            if state.fault == "hangs":
                state.ended.wait(60)
            elif state.redirect:
                self._say(302, b"", Location=state.redirect)
            elif state.fault == "missing":
                self._say(404, b"")
            else:
                self._part()

        do_HEAD = do_GET  # noqa: N815

        def _part(self) -> None:
            asked, whole = self.headers.get("Range"), state.content
            if asked is None or state.fault == "whole":
                return self._say(200, whole)
            first, _, last = asked.removeprefix("bytes=").partition("-")
            begin, end = int(first), min(int(last or len(whole)), len(whole) - 1)
            body = whole[begin : end + 1]
            is_cut = state.fault == "cut" or (state.fault == "cut later" and begin > 0)
            self._say(206, body, cut=is_cut, **{"Content-Range": f"bytes {begin}-{end}/{len(whole)}", **FACTS})
            return None

        def _say(self, status: int, body: bytes, *, cut: bool = False, **headers: str) -> None:
            self.send_response(status)
            for name, value in headers.items():
                self.send_header(name, value)
            self.send_header("Content-Length", str(len(body)))
            self.end_headers()
            if self.command == "GET":
                self.wfile.write(body[: len(body) // 2] if cut else body)
            if cut:
                self.close_connection = True

        def log_message(self, *_: Any) -> None:
            pass

    with http.server.ThreadingHTTPServer(("127.0.0.1", 0), Handler) as server:
        server.daemon_threads = True
        state.port = server.server_address[1]
        thread = threading.Thread(target=server.serve_forever, args=(0.02,), daemon=True)
        thread.start()
        try:
            yield state
        finally:
            state.ended.set()
            server.shutdown()
            thread.join()
