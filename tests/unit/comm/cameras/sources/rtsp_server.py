"""A small RTSP camera (RFC 2326, RTP in the TCP connection) that sends uncompressed pictures (RFC 4175)."""

from __future__ import annotations

import asyncio
import contextlib
import struct

WIDTH, HEIGHT = 32, 16
_PAYLOAD = 96
_SDP = f"""v=0
o=- 1 1 IN IP4 127.0.0.1
s=camera
t=0 0
m=video 0 RTP/AVP {_PAYLOAD}
c=IN IP4 0.0.0.0
a=rtpmap:{_PAYLOAD} raw/90000
a=fmtp:{_PAYLOAD} sampling=RGB; width={WIDTH}; height={HEIGHT}; depth=8; colorimetry=SMPTE240M
a=control:track
""".replace("\n", "\r\n")


class RtspCamera:
    """Sends one grey, 30 pictures a second, to every client. ``is_silent``: the connection stays, nothing comes."""

    def __init__(self, grey: int = 100) -> None:
        self.grey = grey
        self.is_silent = False
        self.paths: list[str] = []
        self._server: asyncio.Server | None = None
        self._clients: set[asyncio.Task[None]] = set()

    async def start(self, port: int = 0) -> int:
        """Listen on loopback; return the port."""
        self._server = await asyncio.start_server(self._accept, "127.0.0.1", port)
        return int(self._server.sockets[0].getsockname()[1])

    async def close(self) -> None:
        """End all connections."""
        if self._server is not None:
            self._server.close()
        for task in tuple(self._clients):
            task.cancel()
        await asyncio.gather(*self._clients, return_exceptions=True)

    async def _accept(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        task = asyncio.current_task()
        assert task is not None
        self._clients.add(task)
        sender: asyncio.Task[None] | None = None
        try:
            while request := await _request(reader):
                method, url, number = request
                self.paths.append(f"{method} {url}")
                writer.write(_answer(method, number))
                if method == "PLAY":
                    sender = asyncio.create_task(self._send(writer))
        except (ConnectionError, asyncio.CancelledError, asyncio.IncompleteReadError):
            pass
        finally:
            if sender is not None:
                sender.cancel()
                await asyncio.gather(sender, return_exceptions=True)
            self._clients.discard(task)
            writer.close()
            with contextlib.suppress(ConnectionError):
                await writer.wait_closed()

    async def _send(self, writer: asyncio.StreamWriter) -> None:
        for count in range(1 << 16):
            if not self.is_silent:
                packet = _picture(count, self.grey)
                writer.write(struct.pack(">cBH", b"$", 0, len(packet)) + packet)
            await asyncio.sleep(1 / 30)


async def _request(reader: asyncio.StreamReader) -> tuple[str, str, str] | None:
    """Return method, address and CSeq of the next request; skip the client's RTCP."""
    while first := await reader.read(1):
        if first == b"$":
            _, size = struct.unpack(">BH", await reader.readexactly(3))
            await reader.readexactly(size)
            continue
        lines = (first + await reader.readuntil(b"\r\n\r\n")).decode().split("\r\n")
        method, url, _ = lines[0].split(" ", 2)
        fields = dict(line.split(": ", 1) for line in lines[1:] if ": " in line)
        return method, url, fields["CSeq"]
    return None


def _answer(method: str, number: str) -> bytes:
    head = ["RTSP/1.0 200 OK", f"CSeq: {number}", "Session: 1"]
    body = ""
    if method == "OPTIONS":
        head.append("Public: OPTIONS, DESCRIBE, SETUP, PLAY, TEARDOWN, GET_PARAMETER")
    elif method == "DESCRIBE":
        body = _SDP
        head += ["Content-Type: application/sdp", f"Content-Length: {len(body)}"]
    elif method == "SETUP":
        head.append("Transport: RTP/AVP/TCP;unicast;interleaved=0-1")
    return ("\r\n".join(head) + "\r\n\r\n" + body).encode()


def _picture(count: int, grey: int) -> bytes:
    """Return one RTP packet that holds a whole picture."""
    row = bytes([grey]) * (3 * WIDTH)
    header = struct.pack(">BBHII", 0x80, 0x80 | _PAYLOAD, count & 0xFFFF, count * 3000, 1)
    more = [struct.pack(">HHH", len(row), line, 0x8000 if line + 1 < HEIGHT else 0) for line in range(HEIGHT)]
    return header + struct.pack(">H", 0) + b"".join(more) + row * HEIGHT
