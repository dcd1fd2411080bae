"""Fuzzed bytes on bare connections: HTTP requests, and WebSocket frames after a proper handshake."""

from __future__ import annotations

import asyncio
import contextlib
import random
import struct
from typing import Final

PATHS: Final = (
    "/", "/ws", "/video", "/stream.mjpg", "/snapshot.jpg", "/metrics", "/api/health", "/api/schema.json",
    "/api/report.json", "/api/stalls.csv", "/api/stalls.geojson", "/api/performance", "/api/mosaic/0/0.jpg?v=1&map=x",
)  # fmt: skip
_ODD_PATHS: Final = (
    "/..%2f..%2fetc/passwd", "//", "/%00", "/%", "/api/mosaic/999999999/0.jpg", "*", "http://elsewhere/", "/?token=x",
    "/" + "a" * 9000, "/?" + "&".join(["q=1"] * 500), "/\xff", "/a b",
)  # fmt: skip
_METHODS: Final = ("GET", "GET", "GET", "HEAD", "POST", "OPTIONS", "DELETE", "TRACE", "CONNECT", "get", "BREW", "")
_ODD_HEADERS: Final = (
    "Host: elsewhere", "Host:", "Content-Length: 10", "Content-Length: -1", "Content-Length: 5\r\nContent-Length: 6",
    "Transfer-Encoding: chunked", "Transfer-Encoding: gzip, chunked", "Upgrade: websocket", "Upgrade: h2c",
    "Connection: Upgrade", "Connection: close", "Expect: 100-continue", "Origin: http://evil.example",
    "Range: bytes=0-",
    "Authorization: Bearer x", "Authorization: Basic %%%", "Cookie: hawk_session_80=%00; =; a", "If-None-Match: *",
    "Accept-Encoding: br;q=0, gzip;q=abc", "X: " + "y" * 9000, "Bad Header: 1", "\x00: 1", " folded: 1",
    "Sec-WebSocket-Version: 8", "Sec-WebSocket-Key: short", "Content-Encoding: deflate",
)  # fmt: skip
PATIENCE_S: Final = 0.3
"""Real seconds of silence after which the answer is taken as whole."""
HANDSHAKE: Final = (
    "GET {path} HTTP/1.1\r\nHost: 127.0.0.1:{port}\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
    "Sec-WebSocket-Version: 13\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n\r\n"
)


def request(rng: random.Random, port: int) -> bytes:
    """Return the bytes of one connection: a request with faults, several, a part of one, or noise."""
    if rng.random() < 0.05:
        return rng.randbytes(rng.randrange(1, 600))
    text = "".join(_one(rng, port) for _ in range(rng.choice((1, 1, 1, 2, 40))))
    data = text.encode("latin-1")
    fault = rng.randrange(6)
    if fault == 0:
        data = data[: rng.randrange(len(data))]
    elif fault == 1:
        at = rng.randrange(len(data))
        data = data[:at] + rng.randbytes(rng.randrange(1, 20)) + data[at:]
    elif fault == 2:
        at = rng.randrange(len(data))
        data = data[:at] + data[at + rng.randrange(1, 20) :]
    return data


def frames(rng: random.Random) -> bytes:
    """Return WebSocket frames with faults (RFC 6455, section 5.2)."""
    return b"".join(_frame(rng) for _ in range(rng.randrange(1, 6)))


def _one(rng: random.Random, port: int) -> str:
    path = rng.choice(PATHS if rng.random() < 0.7 else _ODD_PATHS)
    version = rng.choice(("HTTP/1.1", "HTTP/1.1", "HTTP/1.1", "HTTP/1.0", "HTTP/2.0", "HTTP/9.9", ""))
    headers = [f"Host: 127.0.0.1:{port}"] if rng.random() < 0.9 else []
    headers += rng.sample(_ODD_HEADERS, rng.choice((0, 0, 1, 2, 5)))
    if rng.random() < 0.02:
        headers += [f"X-{n}: 1" for n in range(400)]
    body = rng.choice(("", "", "5\r\nhello\r\n0\r\n\r\n", "ffffffffffffffff\r\n", "x" * 100))
    return "\r\n".join((f"{rng.choice(_METHODS)} {path} {version}", *headers, "", "")) + body


def _frame(rng: random.Random) -> bytes:
    opcode = rng.choice((0, 1, 1, 1, 2, 3, 8, 9, 10, 11, 15))
    first = opcode | (0x80 if rng.random() < 0.8 else 0) | rng.choice((0, 0, 0, 0x10, 0x20, 0x40))
    payload = rng.choice((b"", b'{"Type":"Hold"}', b"\xff\xfe", rng.randbytes(rng.randrange(300)), b'{"ack":1}'))
    claimed = rng.choice((len(payload), len(payload), len(payload), len(payload) + 5, 2**40, 2**63))
    masked = 0x80 if rng.random() < 0.8 else 0
    mask = rng.randbytes(4)
    if claimed < 126:
        head = struct.pack("!BB", first, masked | claimed)
    elif claimed < 65536:
        head = struct.pack("!BBH", first, masked | 126, claimed)
    else:
        head = struct.pack("!BBQ", first, masked | 127, claimed)
    body = bytes(byte ^ mask[at % 4] for at, byte in enumerate(payload)) if masked else payload
    return head + (mask if masked else b"") + body


async def exchange(port: int, data: bytes, path: str | None = None) -> str:
    """Send the bytes on a connection of their own; return what is wrong with the answer, empty when nothing is.

    ``path``: a WebSocket is opened there first.
    """
    try:
        reader, writer = await asyncio.open_connection("127.0.0.1", port)
    except OSError as error:
        return f"no connection: {error}"
    received = b""
    try:
        if path is not None:
            writer.write(HANDSHAKE.format(path=path, port=port).encode())
        writer.write(data)
        with contextlib.suppress(ConnectionError, TimeoutError):
            while len(received) < 1_000_000:
                async with asyncio.timeout(PATIENCE_S):
                    if not (more := await reader.read(65536)):
                        break
                received += more
    finally:
        writer.transport.abort()
    return _problem(received)


def _problem(received: bytes) -> str:
    """Return what is wrong with the bytes of an answer: only an answer of the server's own fault is."""
    if not received:
        return ""  # a part of a request has no answer
    line = received.split(b"\r\n", 1)[0]
    parts = line.split(b" ")
    if not line.startswith(b"HTTP/") or len(parts) < 2 or not parts[1].isdigit():
        return f"no answer in HTTP: {received[:100]!r}"
    status = int(parts[1])
    if status >= 500 and status not in (503, 505):
        return f"status {status}: {received[:300]!r}"
    return ""
